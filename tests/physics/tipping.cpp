// timeout: 600
// Cylinders and prisms that stand below their tipping angle, and bodies whose centre is over the
// face on which they rest, are at rest: the points of a manifold carry a load anywhere in it.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <talus/mesh.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/frame.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class... More>
using scene = scenario<bodies<box, cylinder, convex_polyhedron, triangle_mesh, plane>,
                       transport<serial>, More...>;

/// A regular prism; its first corner lies along x.
convex_polyhedron prism(int sides, real radius, real height) {
  std::vector<vec3> corners;
  for (int k = 0; k < sides; ++k)
    for (const real z : {-height / 2, height / 2}) {
      const real angle = 2 * pi * k / sides;
      corners.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  return convex_polyhedron(corners);
}
/// How far it reaches from its axis along a direction at this angle from its first corner.
real reach_of_prism(int sides, real radius, real angle) {
  const real half = pi / sides;
  const real from = std::abs(std::remainder(angle, 2 * half));
  return radius * std::cos(half) / std::cos(half - from);
}

enum class ground { plane, box, mesh };
constexpr ground all_grounds[] = {ground::plane, ground::box, ground::mesh};

/// The ground through the origin, sloping down along x.
template <class World>
void put_ground(World& w, ground what, real slope, real size) {
  const quat q = rotation({0, 1, 0}, slope);
  w.global([&](auto& s) {
    if (what == ground::plane) s.add(plane{.normal = rotated(q, vec3(0, 0, 1)), .offset = 0}, {});
    if (what == ground::box)
      s.add(body<box>{.shape = box{{20 * size, 20 * size, size}},
                      .position = rotated(q, vec3(0, 0, -size / 2)),
                      .orientation = q});
    if (what == ground::mesh) {
      const auto at = [&](real x, real y) { return rotated(q, vec3(x * size, y * size, 0)); };
      const triangle_mesh m(std::vector<triangle_mesh::triangle>{
          {at(-9, -9), at(9, -8), at(9, 9)}, {at(-9, -9), at(9, 9), at(-9, 9)}});
      const pose p = placed(m);
      s.add(body<triangle_mesh>{.shape = m, .position = p.position, .orientation = p.orientation});
    }
  });
}

/// How far bodies move from the end of the first second to the tenth, and how fast they are at
/// most; relative to their size.
struct motion {
  real way = 0, speed = 0;
};
template <class World>
motion watch(World& w, real size, real dt) {
  const int before = static_cast<int>(std::lround(1 / dt)),
            steps = static_cast<int>(std::lround(10 / dt));
  std::vector<vec3> start;
  motion m;
  for (int k = 0; k < steps; ++k) {
    w.step(dt);
    if (k < before) continue;
    std::size_t i = 0;
    w.for_each_local([&](const auto& b) {
      if (k == before) start.push_back(b.position());
      m.way = std::max(m.way, (b.position() - start[i++]).norm() / size);
      m.speed = std::max(m.speed, b.velocity().norm() / size);
    });
  }
  return m;
}

struct setting {
  ground below = ground::plane;
  real part = 0.8;  ///< of the tipping angle, or of the way to the edge
  real turn = 0;    ///< about the axis
  real size = 0.5, dt = 1.0 / 240;
};
constexpr real g = 9.81;
template <class Scenario, class Put>
void check_rest(const std::string& name, const setting& x, real slope, Put&& put) {
  serial::link link;
  world<Scenario> w{link};
  w.material({.density = 1, .restitution = 0, .friction = 3});
  w.gravity({0, 0, -g});
  put_ground(w, x.below, slope, x.size);
  put(w, rotation({0, 1, 0}, slope));
  const motion m = watch(w, x.size, x.dt);
  INFO(name, " on ground ", static_cast<int>(x.below), ", ", x.part, " of the limit, turned ",
       x.turn, ", size ", x.size, ", dt ", x.dt, ": way ", m.way, ", speed ", m.speed);
  CHECK(m.way < 1e-6);
  CHECK(m.speed < 5e-5);
}

template <class Scenario>
void check_alone(const setting& x) {
  const real r = x.size, h = 2 * r;
  const auto stand = [&](const auto& shape, auto& w, const quat& q, real height = 0.5) {
    w.add(body{.shape = shape,
               .position = rotated(q, vec3(0, 0, height * h)),
               .orientation = q * rotation({0, 0, 1}, x.turn)});
  };
  check_rest<Scenario>("cylinder", x, x.part * std::atan(2 * r / h), [&](auto& w, const quat& q) {
    stand(cylinder{r, h}, w, q);
  });
  for (const int sides : {6, 8})
    check_rest<Scenario>("prism of " + std::to_string(sides) + " sides", x,
                         x.part * std::atan(2 * reach_of_prism(sides, r, x.turn) / h),
                         [&](auto& w, const quat& q) { stand(prism(sides, r, h), w, q); });
}
template <class Scenario>
void check_stacked(const setting& x) {
  const real r = x.size, h = 2 * r;
  const auto stack = [&](auto& w, const quat& q, const auto& lower, const auto& upper) {
    w.add(body{.shape = lower,
               .position = rotated(q, vec3(0, 0, h / 2)),
               .orientation = q * rotation({0, 0, 1}, x.turn)});
    w.add(body{.shape = upper,
               .position = rotated(q, vec3(0, 0, 3 * h / 2)),
               .orientation = q * rotation({0, 0, 1}, x.turn + 1)});
  };
  check_rest<Scenario>("stack of cylinders", x, x.part * std::atan(r / h),
                       [&](auto& w, const quat& q) {
                         stack(w, q, cylinder{r, h}, cylinder{r, h});
                       });
  check_rest<Scenario>(
      "prism on prism", x, x.part * std::atan(r * std::cos(pi / 6) / h),
      [&](auto& w, const quat& q) { stack(w, q, prism(8, r, h), prism(6, r, h)); });
  check_rest<Scenario>("box over a cylinder", x, 0, [&](auto& w, const quat&) {
    w.add(body{.shape = cylinder{r, h}, .position = {0, 0, h / 2}});
    w.add(body{
        .shape = box{{3 * r, 3 * r, 0.6 * r}},
        .position = {x.part * r * std::cos(x.turn), x.part * r * std::sin(x.turn), h + 0.3 * r}});
  });
  check_rest<Scenario>("box over a box turned by 45 degrees", x, 0, [&](auto& w, const quat&) {
    w.add(body{.shape = box{{h, h, h}}, .position = {0, 0, h / 2}});
    w.add(body{.shape = box{{h, h, 0.6 * r}},
               .position = {0.3 * x.part * r * std::cos(x.turn),
                            0.3 * x.part * r * std::sin(x.turn), h + 0.3 * r},
               .orientation = rotation({0, 0, 1}, pi / 4)});
  });
}

}  // namespace

TEST_CASE("cylinders and prisms stand still up to 0.95 of their tipping angle") {
  for (const ground below : all_grounds)
    for (const real part : {0.6, 0.8, 0.95})
      for (const real turn : {0., 0.1963, pi / 4}) check_alone<scene<>>({below, part, turn});
}
TEST_CASE("stacks of them do, and boxes with their centre over a cylinder or a box") {
  for (const ground below : all_grounds)
    for (const real part : {0.6, 0.95})
      for (const real turn : {0.1963, pi / 4}) check_stacked<scene<>>({below, part, turn});
}
TEST_CASE("towers of cylinders on a slope stand still from the first step on") {
  for (const int rows : {3, 5, 9, 12})
    for (const real part : {0.6, 0.95}) {
      constexpr real r = 0.5, h = 0.4;
      const real slope = part * std::atan(2 * r / (rows * h));
      const quat q = rotation({0, 1, 0}, slope);
      serial::link link;
      world<scene<>> w{link};
      w.material({.density = 1, .restitution = 0, .friction = 3});
      w.gravity({0, 0, -g});
      put_ground(w, ground::plane, slope, r);
      std::vector<vec3> start;
      for (int k = 0; k < rows; ++k) {
        start.push_back(rotated(q, vec3(0, 0, (k + 0.5) * h)));
        w.add(body{.shape = cylinder{r, h}, .position = start.back(), .orientation = q});
      }
      real way = 0;
      for (int step = 0; step < 1200; ++step) {
        w.step(1.0 / 240);
        std::size_t i = 0;
        w.for_each_local(
            [&](const auto& b) { way = std::max(way, (b.position() - start[i++]).norm() / r); });
      }
      INFO(rows, " cylinders, ", part, " of the tipping angle");
      CHECK(way < 5e-6);
    }
}
TEST_CASE("a box almost over the rim of a flat cylinder is at rest from the first step on") {
  for (const real dt : {1.0 / 60, 1.0 / 100, 1.0 / 240})
    for (const real part : {0.75, 0.95})
      for (const real turn : {0., 0.2, pi / 4, 1.})
        for (const real height : {0.4, 1., 3.}) {
          constexpr real r = 0.5;
          const real h = height * r;
          serial::link link;
          world<scene<>> w{link};
          w.material({.density = 1, .restitution = 0, .friction = 3});
          w.gravity({0, 0, -g});
          put_ground(w, ground::plane, 0, r);
          const vec3 start(part * r * std::cos(turn), part * r * std::sin(turn), h + 0.3 * r);
          w.add(body{.shape = cylinder{r, h},
                     .position = {0, 0, h / 2},
                     .orientation = rotation({0, 0, 1}, 0.3)});
          const auto above = w.add(body{.shape = box{{3 * r, 3 * r, 0.6 * r}}, .position = start});
          real way = 0;
          for (int k = 0; k < static_cast<int>(std::lround(10 / dt)); ++k) {
            w.step(dt);
            way = std::max(way, (w[above].position() - start).norm() / r);
          }
          INFO(part, " of the radius, turned ", turn, ", height ", height, ", dt ", dt);
          CHECK(way < 1e-6);
        }
}
TEST_CASE("they do whatever their size and the time step, and with the reproducible solver") {
  for (const real part : {0.7, 0.95}) {
    check_alone<scene<>>({.part = part, .turn = 0.4, .size = 0.02, .dt = 1.0 / 1000});
    check_alone<scene<>>({.part = part, .turn = 0.4, .size = 10, .dt = 1.0 / 60});
    check_alone<scene<solver<reproducible>>>({.part = part, .turn = 0.4});
    check_stacked<scene<solver<reproducible>>>({.part = part, .turn = 0.4});
  }
}

TEST_CASE("on one rank and on two they fall asleep, with the default and the reproducible solver") {
  const auto check = []<class... More>(type_list<More...>, int ranks) {
    using divided = scenario<bodies<box, cylinder, convex_polyhedron, plane>, features<sleeping>,
                             decomposition<grid<dynamic>>, transport<threads>, More...>;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<divided> w(link, grid<dynamic>{.cells = {ranks}, .lower = {-8}, .upper = {8}});
      w.material({.density = 1, .restitution = 0, .friction = 3});
      const real r = 0.5, slope = 0.9 * std::atan(r / (2 * r));
      w.gravity({g * std::sin(slope), 0, -g * std::cos(slope)});
      w.global([&](auto& s) { s.add(plane{}, {}); });
      // Stacks at the border: their bodies are of different ranks.
      for (int n = 0; n < 4; ++n) {
        const real y = 3 * n;
        const auto put = [&](real x, real z, const auto& shape) {
          w.add_if_local(body{.shape = shape,
                              .position = {x, y, z},
                              .orientation = rotation({0, 0, 1}, 0.2 + 0.3 * n + z)});
        };
        put(-0.02, r, cylinder{r, 2 * r});
        if (n % 2 == 0)
          put(0.02, 3 * r, cylinder{r, 2 * r});
        else
          put(0.02, 2.3 * r, box{{3 * r, 3 * r, 0.6 * r}});
      }
      (void)watch(w, r, 1.0 / 240);
      const auto m = measure_motion(w);
      CHECK(m.asleep == 8);
    });
  };
  for (const int ranks : {1, 2}) {
    check(type_list<>{}, ranks);
    check(type_list<solver<reproducible>>{}, ranks);
  }
}
