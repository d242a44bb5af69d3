// Fixed surfaces that lie flush beside each other are one surface for what slides, rolls and rests
// on them, whatever they are made of.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <concepts>
#include <functional>
#include <string>
#include <talus/mesh.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "../landscape.hpp"

using namespace talus;

namespace {

template <class... More>
using scene_with =
    scenario<bodies<sphere, box, convex_polyhedron, triangle_mesh, plane>,
             hard_contact<coulomb_friction, newton_restitution>, transport<serial>, More...>;
using scene = scene_with<>;
using followed = scene_with<features<continuous_collision>>;
using triangles = std::vector<triangle_mesh::triangle>;

/// A rectangle of two triangles at the height z.
triangles rectangle(real x0, real x1, real y0, real y1, real z = 0) {
  const vec3 a(x0, y0, z), b(x1, y0, z), c(x1, y1, z), d(x0, y1, z);
  return {{a, b, c}, {a, c, d}};
}
triangles joined(triangles a, const triangles& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A floor at z = 0 around the origin, with a seam at x = 0 or more of them.
template <class Scenario>
struct floor_kind {
  std::string name;
  std::function<void(world<Scenario>&)> build;
};
template <class Shape, class Scenario>
void put(world<Scenario>& w, const Shape& shape, const vec3& at, bool fixed = false) {
  if (fixed)
    (void)w.add(body<Shape>{.shape = shape, .position = at, .fixed = true});
  else
    w.global([&](auto& scope) { scope.add(body<Shape>{.shape = shape, .position = at}); });
}
template <class Scenario>
void put(world<Scenario>& w, const triangles& all) {
  const triangle_mesh m(all);
  const pose at = placed(m);
  w.global([&](auto& scope) {
    scope.add(
        body<triangle_mesh>{.shape = m, .position = at.position, .orientation = at.orientation});
  });
}
convex_polyhedron block(real x0, real x1, real y0, real y1, real z0) {
  std::vector<vec3> corners;
  for (const real x : {x0, x1})
    for (const real y : {y0, y1})
      for (const real z : {z0, real(0)}) corners.push_back({x, y, z});
  return convex_polyhedron(corners);
}
template <class Scenario>
void put_block(world<Scenario>& w, real x0, real x1, real y0, real y1, real z0) {
  const convex_polyhedron p = block(x0, x1, y0, y1, z0);
  put(w, p, p.frame().position);
}

template <class Scenario>
const std::vector<floor_kind<Scenario>>& floors() {
  static const std::vector<floor_kind<Scenario>> all{
      {"one box",
       [](auto& w) {
         put(w, box{{2, 2, 0.2}}, {0, 0, -0.1});
       }},
      {"two boxes",
       [](auto& w) {
         put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
         put(w, box{{1, 2, 0.3}}, {0.5, 0, -0.15});
       }},
      {"two fixed boxes",
       [](auto& w) {
         put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1}, true);
         put(w, box{{1, 2, 0.3}}, {0.5, 0, -0.15}, true);
       }},
      {"boxes at a T-junction",
       [](auto& w) {
         put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
         put(w, box{{1, 1, 0.2}}, {0.5, -0.495, -0.1});
         put(w, box{{1, 1, 0.2}}, {0.5, 0.505, -0.1});
       }},
      {"a row of narrow boxes",
       [](auto& w) {
         for (int k = -40; k < 40; ++k) put(w, box{{0.025, 2, 0.2}}, {(k + 0.5) * 0.025, 0, -0.1});
       }},
      {"overlapping boxes",
       [](auto& w) {
         put(w, box{{1.2, 2, 0.2}}, {-0.5, 0, -0.1});
         put(w, box{{1.2, 2, 0.3}}, {0.5, 0, -0.15});
       }},
      {"two hulls",
       [](auto& w) {
         put_block(w, -1, 0, -1, 1, -0.2);
         put_block(w, 0, 1, -1, 1, -0.3);
       }},
      {"two meshes",
       [](auto& w) {
         put(w, rectangle(-1, 0, -1, 1));
         put(w, rectangle(0, 1, -1, 1));
       }},
      {"a box sunk into a plane",
       [](auto& w) {
         w.global([](auto& scope) { scope.add(plane{}, {}); });
         put(w, box{{0.5, 0.5, 0.2}}, {0.25, 0.02, -0.1});
       }},
      {"a plane after a box sunk into it",
       [](auto& w) {
         put(w, box{{0.5, 0.5, 0.2}}, {0.25, 0.02, -0.1});
         w.global([](auto& scope) { scope.add(plane{}, {}); });
       }},
      {"one mesh", [](auto& w) { put(w, rectangle(-1, 1, -1, 1)); }},
      {"a row of narrow boxes over a large one",
       [](auto& w) {
         put(w, box{{4, 4, 0.2}}, {0, 0, -0.3});
         for (int k = -40; k < 40; ++k) put(w, box{{0.025, 2, 0.2}}, {(k + 0.5) * 0.025, 0, -0.1});
       }},
      {"a box and a mesh",
       [](auto& w) {
         put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
         put(w, rectangle(0, 1, -1, 1));
       }},
      {"a mesh and a box",
       [](auto& w) {
         put(w, rectangle(-1, 0, -1, 1));
         put(w, box{{1, 2, 0.2}}, {0.5, 0, -0.1});
       }},
      {"a box and a hull",
       [](auto& w) {
         put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
         put_block(w, 0, 1, -1, 1, -0.3);
       }},
      {"triangles with jittered corners",
       [](auto& w) {
         triangles all = joined(rectangle(-1, 0, -1, 1), rectangle(0, 1, -1, 1));
         real way = 1e-16;
         for (auto& t : all)
           for (vec3& v : t) v[0] += way, v[2] += way, way = -way;
         put(w, all);
       }},
      {"triangles at a T-junction",
       [](auto& w) {
         put(w, joined(rectangle(-1, 0, -1, 1),
                       joined(rectangle(0, 1, -1, 0.013), rectangle(0, 1, 0.013, 1))));
       }},
      {"a triangle twice",
       [](auto& w) {
         triangles all = joined(rectangle(-1, 0, -1, 1), rectangle(0, 1, -1, 1));
         all.push_back(all[2]);
         put(w, all);
       }},
  };
  return all;
}

struct course {
  real speed = 0;   ///< largest change of the velocity, over the speed at the start
  real height = 0;  ///< largest change of the height, over the size
  real spin = 0;    ///< largest angular velocity, times size over speed
  real way = 0;     ///< the way travelled less that at the speed, over the latter
};
template <class Scenario, class Shape>
course slide(const floor_kind<Scenario>& floor, const Shape& shape, real height, real size,
             const vec3& v, real dt, const material& stuff, const vec3& spin = {0, 0, 0},
             real tolerance = 1e-12) {
  serial::link link;
  world<Scenario> w(link);
  w.gravity({0, 0, -9.81});
  w.material(stuff);
  w.solver().tolerance = tolerance;  // so that contacts of many bodies converge
  floor.build(w);
  // Half of the way before the seam.
  const real way = std::max(2.5 * size, 6 * v.norm() * dt);
  const vec3 ahead = v.normalized();
  const vec3 start = vec3(0, 0, height) - way / 2 * ahead;
  const auto mover = w.add(
      body<Shape>{.shape = shape, .position = start, .velocity = v, .angular_velocity = spin});
  course c;
  const int steps = static_cast<int>(std::min(way / v.norm() / dt, real(4000)));
  for (int k = 0; k < steps; ++k) {
    w.step(dt);
    const auto& b = w[mover];
    c.speed = std::max(c.speed, (b.velocity() - v).norm() / v.norm());
    c.height = std::max(c.height, std::abs(b.position()[2] - height) / size);
    c.spin = std::max(c.spin, (b.angular_velocity() - spin).norm() * size / v.norm());
  }
  const real gone = steps * dt * v.norm();
  c.way = std::abs((w[mover].position() - start).dot(ahead) - gone) / gone;
  return c;
}

void require_smooth(const course& c) {
  CHECK(c.speed < 1e-6);
  CHECK(c.height < 1e-6);
  CHECK(c.spin < 1e-6);
  CHECK(c.way < 1e-6);
}

constexpr std::array speeds{0.05, 2.0, 10.0};
constexpr std::array steps{1.0 / 60, 1.0 / 240, 1.0 / 1000};
/// The longest way in a step: what is not followed meets seams at the start of the step.
template <class Scenario>
constexpr real most_way = std::same_as<Scenario, followed> ? 0.2 : 0.1;

}  // namespace

TEST_CASE_TEMPLATE("a cube slides over any seam of flush surfaces without a bump", Scenario, scene,
                   followed) {
  for (const auto& floor : floors<Scenario>())
    for (const real speed : speeds)
      for (const real dt : steps)
        for (const vec3& ahead : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0.8, 0.6, 0)}) {
          if (speed * dt > most_way<Scenario>) continue;
          CAPTURE(floor.name);
          CAPTURE(speed);
          CAPTURE(dt);
          CAPTURE(ahead[0]);
          require_smooth(slide(floor, box{{0.06, 0.06, 0.06}}, 0.03, 0.06, speed * ahead, dt,
                               {.restitution = 0, .friction = 0}));
        }
}

TEST_CASE("it does so with the ten iterations of the default") {
  for (const auto& floor : floors<scene>())
    for (const real dt : steps)
      for (const vec3& ahead : {vec3(1, 0, 0), vec3(-0.8, 0.6, 0)}) {
        CAPTURE(floor.name);
        CAPTURE(dt);
        CAPTURE(ahead[0]);
        require_smooth(slide(floor, box{{0.06, 0.06, 0.06}}, 0.03, 0.06, 2 * ahead, dt,
                             {.restitution = 0, .friction = 0}, {0, 0, 0}, 0));
      }
}

TEST_CASE_TEMPLATE("a sphere slides over any seam of flush surfaces without a bump", Scenario,
                   scene, followed) {
  for (const auto& floor : floors<Scenario>())
    for (const real speed : speeds)
      for (const real dt : steps)
        for (const real restitution : {0.0, 0.5})
          for (const vec3& ahead : {vec3(1, 0, 0), vec3(-0.8, 0.6, 0)}) {
            if (speed * dt > most_way<Scenario>) continue;
            CAPTURE(floor.name);
            CAPTURE(speed);
            CAPTURE(dt);
            CAPTURE(ahead[0]);
            require_smooth(slide(floor, sphere{0.03}, 0.03, 0.03, speed * ahead, dt,
                                 {.restitution = restitution, .friction = 0}));
          }
}

TEST_CASE("a hull slides over seams of flush surfaces without a bump") {
  const convex_polyhedron prism({{-0.03, -0.03, -0.02},
                                 {0.03, -0.03, -0.02},
                                 {0.03, 0.03, -0.02},
                                 {-0.03, 0.03, -0.02},
                                 {-0.02, 0, 0.03},
                                 {0.02, 0, 0.03}});
  const real height = -prism.support({0, 0, -1})[2];
  for (const auto& floor : floors<scene>())
    for (const vec3& ahead : {vec3(1, 0, 0), vec3(-0.8, 0.6, 0)}) {
      CAPTURE(floor.name);
      CAPTURE(ahead[0]);
      require_smooth(slide(floor, prism, height, 0.06, 2 * ahead, 1.0 / 240,
                           {.restitution = 0, .friction = 0}));
    }
}

TEST_CASE("a sphere rolls over seams of flush surfaces at its speed") {
  for (const auto& floor : floors<scene>())
    for (const real speed : {0.01, 1.0})
      for (const vec3& ahead : {vec3(1, 0, 0), vec3(-0.8, 0.6, 0)}) {
        CAPTURE(floor.name);
        CAPTURE(speed);
        CAPTURE(ahead[0]);
        const vec3 v = speed * ahead;
        require_smooth(slide(floor, sphere{0.03}, 0.03, 0.03, v, 1.0 / 240,
                             {.restitution = 0, .friction = 0.5}, vec3(0, 0, 1).cross(v) / 0.03));
      }
}

TEST_CASE("a turned cube does not meet the sides of narrow fixed boxes below it") {
  for (const real angle : {real(0.78), pi / 4, real(1)})
    for (const vec3& v : {vec3(2, 0, 0), vec3(1.6, 1.2, 0)}) {
      serial::link link;
      world<scene> w(link);
      w.gravity({0, 0, -9.81});
      w.material({.restitution = 0, .friction = 0});
      for (int k = -20; k < 30; ++k) put(w, box{{0.01, 2, 0.2}}, {0.01 * k, 0.3, -0.1}, true);
      const auto cube = w.add(body{.shape = box{{0.06, 0.06, 0.06}},
                                   .position = {-0.1, 0, 0.03},
                                   .velocity = v,
                                   .orientation = rotation({0, 0, 1}, angle)});
      for (int k = 0; k < 20; ++k) w.step(1.0 / 240);
      CAPTURE(angle);
      CHECK((w[cube].velocity() - v).norm() < 1e-6 * v.norm());
      CHECK(std::abs(w[cube].position()[2] - 0.03) < 1e-6 * 0.06);
    }
}

TEST_CASE("a sphere rolls from a floor onto a slope and back as over one mesh") {
  // Up a slope of 5 degrees that begins at x = 0, by boxes and by triangles that share the edge.
  const real angle = pi / 36;
  const auto roll = [&](bool of_boxes) {
    serial::link link;
    world<scene> w(link);
    w.gravity({0, 0, -9.81});
    w.material({.restitution = 0, .friction = 0});
    const vec3 up(-std::sin(angle), 0, std::cos(angle)), along(std::cos(angle), 0, std::sin(angle));
    if (of_boxes) {
      put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
      w.global([&](auto& scope) {
        scope.add(body<box>{.shape = box{{1, 2, 0.2}},
                            .position = 0.5 * along - 0.1 * up,
                            .orientation = rotation({0, -1, 0}, angle)});
      });
    } else {
      const vec3 side(0, 1, 0);
      const vec3 c = along + side, d = along - side;
      put(w, joined(rectangle(-1, 0, -1, 1), {{-side, d, c}, {-side, c, side}}));
    }
    const auto ball =
        w.add(body{.shape = sphere{0.03}, .position = {-0.1, 0, 0.03}, .velocity = {0.3, 0, 0}});
    std::vector<vec3> path;
    for (int k = 0; k < 400; ++k) {
      w.step(1.0 / 240);
      path.push_back(w[ball].position());
    }
    return path;
  };
  const auto boxes = roll(true), mesh = roll(false);
  for (std::size_t k = 0; k < boxes.size(); ++k) CHECK((boxes[k] - mesh[k]).norm() < 1e-6);
  CHECK(boxes.back()[0] < -0.05);  // it has come back
}

TEST_CASE("real steps, walls and outer edges act on what slides against them") {
  const auto run = [](auto&& build, const vec3& gravity, const vec3& v, int steps) {
    serial::link link;
    world<scene> w(link);
    w.gravity(gravity);
    w.material({.restitution = 0, .friction = 0});
    build(w);
    const auto cube =
        w.add(body{.shape = box{{0.06, 0.06, 0.06}}, .position = {-0.1, 0, 0.03}, .velocity = v});
    for (int k = 0; k < steps; ++k) w.step(1.0 / 240);
    return std::pair(w[cube].position(), w[cube].velocity());
  };
  // A wall that stands on the floor, one beside it, and one of triangles; pressed into the corner.
  const std::vector<std::function<void(world<scene>&)>> corners{
      [](auto& w) {
        put(w, box{{2, 2, 0.2}}, {0, 0, -0.1});
        put(w, box{{0.2, 2, 1}}, {0.1, 0, 0.5});
      },
      [](auto& w) {
        put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
        put(w, box{{0.2, 2, 1}}, {0.1, 0, 0.1});
      },
      [](auto& w) {
        put(w, rectangle(-1, 0.3, -1, 1));
        put(w, {{vec3(0, -1, -0.2), vec3(0, 1, -0.2), vec3(0, 1, 1)},
                {vec3(0, -1, -0.2), vec3(0, 1, 1), vec3(0, -1, 1)}});
      },
      [](auto& w) {
        w.global([](auto& scope) { scope.add(plane{}, {}); });
        put(w, box{{0.2, 2, 1}}, {0.1, 0, 0.5});
      },
      [](auto& w) {
        put(w, rectangle(-1, 1, -1, 1));
        put(w, box{{0.2, 2, 1}}, {0.1, 0, 0.5});
      },
      // A step of most of its height.
      [](auto& w) {
        put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
        put(w, box{{1, 2, 0.2}}, {0.5, 0, -0.05});
      },
  };
  for (std::size_t k = 0; k < corners.size(); ++k) {
    CAPTURE(k);
    const auto [p, v] = run(corners[k], {8, 0, -9.81}, {1, 0, 0}, 480);
    CHECK((p - vec3(-0.03, 0, 0.03)).norm() < 1e-4);  // upright
    CHECK(v.norm() < 1e-3);
  }
  // Down a step, and over an outer edge.
  const auto [p, v] = run(
      [](auto& w) {
        put(w, box{{1, 2, 0.2}}, {-0.5, 0, -0.1});
      },
      {0, 0, -9.81}, {3, 0, 0}, 30);
  CHECK(p[2] < 0.01);
  CHECK(v[0] == doctest::Approx(3).epsilon(0.05));
}

TEST_CASE("a cube slides along a corner of flush floors and walls without a bump") {
  for (const bool overlapping : {true, false})
    for (const real tilt : {real(0), pi / 4})
      for (const real speed : {0.05, 1.0}) {
        CAPTURE(overlapping);
        CAPTURE(tilt);
        CAPTURE(speed);
        serial::link link;
        world<scene> w(link);
        (void)w.material({.density = 1000, .restitution = 0, .friction = 0});
        w.gravity({0, 0, -9.81});
        const quat q(std::cos(tilt / 2), std::sin(tilt / 2), 0, 0);
        w.global([&](auto& scope) {
          const auto add = [&](const vec3& from, const vec3& to) {
            scope.add(body<box>{.shape = box{to - from},
                                .position = rotated(q, vec3(0.5 * (from + to))),
                                .orientation = q});
          };
          for (const real x : {-1.0, 0.0}) {
            const real below = overlapping ? -0.2 : 0;
            add({x, below, -0.2}, {x + 1, 1, 0});
            add({x, -0.2, below}, {x + 1, 0, 1});
          }
        });
        const auto cube = w.add(body<box>{.shape = box{{0.06, 0.06, 0.06}},
                                          .position = rotated(q, vec3(-0.06, 0.03, 0.03)),
                                          .velocity = {speed, 0, 0},
                                          .orientation = q});
        const real dt = 1.0 / 240;
        for (int k = 0; k * speed * dt < 0.12; ++k) {
          w.step(dt);
          REQUIRE((w[cube].velocity() - vec3(speed, 0, 0)).norm() <= 1e-6 * speed);
        }
      }
}
