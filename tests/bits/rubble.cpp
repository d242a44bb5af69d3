// Three scenes of bodies of many shapes.
#include "rubble.hpp"

#include <talus/shape/surfaces.hpp>
#include <variant>

namespace {

// Spheres that bounce, roll and come to rest.
void set_up_balls(world<rubble>& w) {
  const auto glass = w.material({.density = 2.5, .restitution = 0.6, .friction = 0.4});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { add_tub(scope, 4, glass); });
  w.fill(simple_cubic{.spacing = 0.9, .origin = {-3.5, -3.5, 0.6}} &
             box_region{{-3.6, -3.6, 0.3}, {3.6, 3.6, 2.8}},
         [&](const site& at, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.25, 0.42)},
                       .position = at.position,
                       .material = glass,
                       .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0)),
                       .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9))};
         });
}

// Towers and a wall of boxes, into which others fall.
void set_up_crates(world<rubble>& w) {
  const auto wood = w.material({.density = 0.7, .restitution = 0.1, .friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) { add_tub(scope, 5, wood); });
  for (int k = 0; k < 8; ++k)
    w.add_if_local(body{.shape = box{{1, 0.8, 0.6}},
                        .position = {-3, -3, 0.3 + 0.6 * k},
                        .material = wood,
                        .orientation = rotation({0, 0, 1}, 0.2 * k)});
  for (int row = 0; row < 5; ++row)
    for (int k = 0; k < 6 - row % 2; ++k)
      w.add_if_local(body{.shape = box{{0.98, 0.5, 0.5}},
                          .position = {k - 2.5 + 0.5 * (row % 2), 0, 0.25 + 0.5 * row},
                          .material = wood});
  random_stream random(11);
  for (int k = 0; k < 14; ++k)
    w.add_if_local(body{.shape = box{random.uniform(vec3(0.3, 0.3, 0.3), vec3(0.8, 0.7, 0.6))},
                        .position = {0.6 * (k - 7), 0.3 * (k % 3) - 0.2, 4 + 0.3 * k},
                        .material = wood,
                        .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9)),
                        .orientation = random.rotation()});
}

// Bodies of all shapes in a tub with a cone of triangles that rotates and shakes.
void set_up_shapes(world<rubble>& w) {
  const auto stone = w.material({.density = 2.5, .restitution = 0.3, .friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& scope) {
    add_tub(scope, 4, stone);
    const triangle_mesh hill =
        cone_surface({.lower = 2, .upper = 0.3, .height = 1.1}, {.sectors = 13, .closed = true});
    const pose at = placed(hill);
    const auto turns = scope.add(hill, stone, at.position, at.orientation);
    w.drive(turns, turning{.axis = {0, 0.1, 1}, .speed = 1.3});
    const auto beats = scope.add(box{{3, 0.4, 0.4}}, stone, vec3(0, -2.5, 0.6));
    w.drive(beats, oscillation{.amplitude = {0.3, 0, 0.1}, .frequency = 1.5, .phase = 0.3});
  });
  const dumbbell pair({{sphere{0.3}, {{-0.3, 0, 0}}}, {capsule{0.12, 0.7}, {{0.2, 0, 0}}}});
  w.fill(simple_cubic{.spacing = 1.15, .origin = {-3.2, -3.2, 1.9}} &
             box_region{{-3.4, -3.4, 1.5}, {3.4, 3.4, 4.8}},
         [&](const site& at, random_stream& random)
             -> std::variant<body<sphere>, body<box>, body<capsule>, body<cylinder>,
                             body<convex_polyhedron>, body<dumbbell>> {
           const auto made = [&](const auto& shape) {
             return body{.shape = shape,
                         .position = at.position,
                         .material = stone,
                         .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0)),
                         .angular_velocity = random.uniform(vec3(-9, -9, -9), vec3(9, 9, 9)),
                         .orientation = random.rotation()};
           };
           const auto which = random.integer(6);
           const real r = random.uniform(0.25, 0.45);
           if (which == 0) return made(sphere{r});
           if (which == 1) return made(box{random.uniform(vec3(r, r, r), vec3(0.8, 0.7, 0.6))});
           if (which == 2) return made(capsule{0.6 * r, r});
           if (which == 3) return made(cylinder{r, 1.2 * r});
           if (which == 4) {
             std::vector<vec3> corners;
             for (int k = 0; k < 12; ++k) corners.push_back(1.4 * r * random.unit_vector());
             return made(convex_polyhedron(corners));
           }
           return made(pair);
         });
}

}  // namespace

std::string balls(const course& how) {
  return digest_of(
      how, [](threads::link& link) { return square_world<rubble>(link, 4); }, set_up_balls);
}

std::string crates(const course& how) {
  return digest_of(
      how, [](threads::link& link) { return square_world<rubble>(link, 5); }, set_up_crates);
}

std::string shapes(const course& how) {
  return digest_of(
      how, [](threads::link& link) { return square_world<rubble>(link, 4); },
      [&](world<rubble>& w) {
        set_up_shapes(w);
        if (!how.load.empty()) (void)read_checkpoint(w, how.load);
      },
      [&](world<rubble>& w) {
        if (!how.save.empty() && w.steps() == static_cast<std::uint64_t>(how.steps / 2))
          write_checkpoint(w, how.save);
      });
}
