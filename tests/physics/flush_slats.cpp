// A body on fixed slats, narrow and wide, keeps its speed and height with the ten iterations of
// the default.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/core/random.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <type_traits>
#include <vector>

using namespace talus;

namespace {

template <class... More>
using scene_with = scenario<bodies<box, convex_polyhedron, cylinder>,
                            hard_contact<coulomb_friction, newton_restitution>, More...>;

box cuboid(const box&, const vec3& size) { return box{size}; }
convex_polyhedron cuboid(const convex_polyhedron&, const vec3& size) {
  std::vector<vec3> corners;
  for (int k = 0; k < 8; ++k)
    corners.push_back(0.5 * vec3(k & 1 ? size[0] : -size[0], k & 2 ? size[1] : -size[1],
                                 k & 4 ? size[2] : -size[2]));
  return convex_polyhedron(corners);
}
template <class Shape>
const Shape& any_of() {
  static const Shape one = [] {
    if constexpr (std::is_same_v<Shape, box>)
      return box{{1, 1, 1}};
    else
      return convex_polyhedron({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  }();
  return one;
}

enum class slats { fixed, global, in_turn };

/// Slats along y around the origin, whose upper faces are at z = 0.
template <class Shape, class World>
void put_slats(World& w, slats kind, real width, real reach) {
  const Shape slat = cuboid(any_of<Shape>(), {width, 2, 0.2});
  const int count = static_cast<int>(reach / width) + 1;
  const auto each_at = [&](auto&& f) {
    for (int k = -count; k < count; ++k) f(k, vec3(width * (k + 0.3), 0.2, -0.1));
  };
  const auto is_fixed = [&](int k) {
    return kind == slats::fixed || (kind == slats::in_turn && k % 2 == 0);
  };
  each_at([&](int k, const vec3& at) {
    if (is_fixed(k)) w.add_if_local(body<Shape>{.shape = slat, .position = at, .fixed = true});
  });
  w.global([&](auto& scope) {
    each_at([&](int k, const vec3& at) {
      if (!is_fixed(k)) scope.add(body<Shape>{.shape = slat, .position = at});
    });
  });
}

/// The largest change of velocity, over the speed, of height and of spin.
template <class Scene, class Slat, class Shape>
real error_of(const Shape& shape, slats kind, real width, real dt, real angle, const vec3& v,
              int iterations = 10) {
  serial::link link;
  world<Scene> w(link);
  w.solver().iterations = iterations;
  w.gravity({0, 0, -9.81});
  w.material({.restitution = 0, .friction = 0});
  const int steps = 40;
  const real way = steps * dt * v.norm();
  put_slats<Slat>(w, kind, width, 0.5 * way + 0.1);
  const vec3 start = vec3(0, 0, 0.03) - 0.5 * steps * dt * v;
  const auto cube = w.add(body<Shape>{
      .shape = shape, .position = start, .velocity = v, .orientation = rotation({0, 0, 1}, angle)});
  real error = 0;
  for (int k = 0; k < steps; ++k) {
    w.step(dt);
    const auto& b = w[cube];
    error = std::max({error, (b.velocity() - v).norm() / v.norm(),
                      std::abs(b.position()[2] - 0.03) / 0.06,
                      b.angular_velocity().norm() * 0.06 / v.norm()});
  }
  return error;
}

/// `shape` is 0.06 high.
template <class Scene, class Slat, class Shape>
void check_slats(const Shape& shape, const std::vector<real>& widths = {0.025, 0.01}) {
  for (const slats kind : {slats::fixed, slats::global, slats::in_turn})
    for (const real width : widths)
      for (const real dt : {1.0 / 60, 1.0 / 240, 1.0 / 1000})
        for (const real angle : {real(0), real(0.3), pi / 4})
          for (const vec3& v : {vec3(2, 0, 0), vec3(-1.6, 1.2, 0), vec3(0.05, 0, 0)}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(width);
            CAPTURE(dt);
            CAPTURE(angle);
            CAPTURE(v[0]);
            // Contacts with global and with fixed bodies are in two lists.
            const real most = kind == slats::in_turn && dt > 0.01 ? 5e-6 : 1e-6;
            CHECK(error_of<Scene, Slat>(shape, kind, width, dt, angle, v) < most);
          }
}

template <class... More>
using on_ranks = scene_with<decomposition<grid<dynamic, dynamic>>, transport<threads>,
                            features<checkpoints>, More...>;

/// The digest after cubes and standing cylinders have slid over the cuts between ranks, which are
/// at x = 0 and y = 0. The run is restarted after half of its steps.
template <class Scene>
std::string slid(int before, int after) {
  const std::string file = "/tmp/talus_flush_slats_" + std::to_string(getpid()) + ".h5";
  std::string digest;
  const vec3 v(2, 0, 0);
  const auto run = [&](int ranks, bool restarts) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<Scene> w(link, {.lower = {-1, -1}, .upper = {1, 1}});
      w.gravity({0, 0, -9.81});
      w.material({.restitution = 0, .friction = 0});
      if (restarts)
        read_checkpoint(w, file);
      else
        put_slats<box>(w, slats::fixed, 0.01, 0.5);
      for (int k = -2; k <= 2 && !restarts; ++k) {
        const quat turn = rotation({0, 0, 1}, 0.2 * k);
        w.add_if_local(body{.shape = box{{0.06, 0.06, 0.06}},
                            .position = {-0.15, 0.1 * k, 0.03},
                            .velocity = v,
                            .orientation = turn});
        w.add_if_local(body{.shape = cylinder{0.04, 0.06},
                            .position = {-0.25, 0.1 * k, 0.03},
                            .velocity = v,
                            .orientation = turn});
      }
      for (int k = 0; k < 18; ++k) {
        w.step(1.0 / 240);
        w.for_each_local([&](const auto& b) {
          if (b.is_fixed()) return;
          CHECK((b.velocity() - v).norm() < 1e-6 * v.norm());
          CHECK(std::abs(b.position()[2] - 0.03) < 1e-6 * 0.06);
        });
      }
      if (!restarts) write_checkpoint(w, file);
      const auto all = state_digest(w);
      if (link.rank() == 0) digest = all;
    });
  };
  run(before, false), run(after, true);
  unlink(file.c_str());
  return digest;
}

}  // namespace

TEST_CASE_TEMPLATE("a cube keeps its speed and height on slats much narrower than it", Scene,
                   scene_with<transport<serial>>,
                   scene_with<transport<serial>, solver<reproducible>>) {
  check_slats<Scene, box>(box{{0.06, 0.06, 0.06}});
}

TEST_CASE_TEMPLATE("so do a standing cylinder and an octagonal prism on slats and on one floor",
                   Scene, scene_with<transport<serial>>,
                   scene_with<transport<serial>, solver<reproducible>>) {
  const std::vector<real> widths{10, 0.1, 0.025, 0.01};
  check_slats<Scene, box>(cylinder{0.04, 0.06}, widths);
  std::vector<vec3> corners;
  for (int k = 0; k < 16; ++k)
    corners.push_back(
        {0.04 * std::cos(0.25 * pi * k), 0.04 * std::sin(0.25 * pi * k), k < 8 ? -0.03 : 0.03});
  check_slats<Scene, box>(convex_polyhedron(corners), widths);
}

TEST_CASE("so does a hull on slats that are hulls") {
  const auto cube = cuboid(any_of<convex_polyhedron>(), {0.06, 0.06, 0.06});
  check_slats<scene_with<transport<serial>>, convex_polyhedron>(cube);
}

TEST_CASE("where fixed and global slats meet, a cube keeps speed and height to 1e-6") {
  using scene = scene_with<transport<serial>>;
  using reproduced = scene_with<transport<serial>, solver<reproducible>>;
  const box cube{{0.06, 0.06, 0.06}};
  for (const real width : {10.0, 0.1})
    for (const real dt : {1.0 / 60, 1.0 / 240})
      for (const real angle : {real(0), real(0.3), pi / 4})
        for (const vec3& v : {vec3(2, 0, 0), vec3(-1.6, 1.2, 0), vec3(0.05, 0, 0)}) {
          CAPTURE(width);
          CAPTURE(dt);
          CAPTURE(angle);
          CAPTURE(v[0]);
          CHECK(error_of<scene, box>(cube, slats::in_turn, width, dt, angle, v) < 1e-6);
          // Sweeps alone need more of them.
          CHECK(error_of<reproduced, box>(cube, slats::in_turn, width, dt, angle, v, 20) < 1e-6);
          CHECK(error_of<reproduced, box>(cube, slats::in_turn, width, dt, angle, v) < 3e-5);
        }
}

TEST_CASE(
    "cubes and cylinders slide on several ranks after a restart, with one digest by the "
    "reproducible solver") {
  using reproduced = on_ranks<solver<reproducible>>;
  const auto one = slid<reproduced>(1, 1);
  CHECK(slid<reproduced>(2, 4) == one);
  CHECK(slid<reproduced>(4, 1) == one);
  (void)slid<on_ranks<>>(2, 4);
  (void)slid<on_ranks<>>(4, 2);
}

TEST_CASE("a cylinder rolls at its speed over seams parallel to its axis, at any tilt and size") {
  random_stream random(7);
  INFO("seed 7");
  enum floor { boxes, hulls, narrow };
  for (const floor below : {boxes, hulls, narrow})
    for (int k = 0; k < 200; ++k) {
      const real size = std::pow(10, random.uniform(-3, 3)), speed = 0.05;
      const real dt = k % 2 == 0 ? 1.0 / 240 : 1e-3,
                 angle = k % 3 == 0 ? 0 : random.uniform(-0.3, 0.3);
      const vec3 axis(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 1);
      const quat q = rotation(axis.normalized(), random.uniform(0, 3));
      serial::link link;
      world<scene_with<transport<serial>>> w(link);
      w.material({.density = 1000, .restitution = 0, .friction = 0.5});
      w.gravity(rotated(q, vec3(0, 0, -9.81 * size)));
      const auto slab = [&](real from, real to, bool fixed) {
        body<box> one{.shape = box{size * vec3(to - from, 2, 0.2)},
                      .position = size * rotated(q, vec3(0.5 * (from + to), 0, -0.1)),
                      .orientation = q,
                      .fixed = fixed};
        if (fixed)
          w.add(one);
        else
          w.global([&](auto& scope) { scope.add(one); });
      };
      const auto hull = [&](std::vector<vec3> corners) {
        for (vec3& p : corners) p = size * rotated(q, p);
        const convex_polyhedron shape(corners);
        const pose at = placed(shape);
        w.global([&](auto& scope) {
          scope.add(body{.shape = shape, .position = at.position, .orientation = at.orientation});
        });
      };
      if (below == boxes) slab(-1, 0, false), slab(0, 1, false);
      if (below == narrow)
        for (int n = -3; n < 3; ++n) slab(0.02 * n, 0.02 * (n + 1), n % 3 == 0);
      if (below == hulls) {
        hull({{-1, -1, 0}, {0, -1, 0}, {0, 1, 0}, {-1, 1, 0}, {-1, 0, -0.3}, {0, 0, -0.3}});
        hull({{0, -1, 0}, {1, -1, 0}, {1, 1, 0}, {0, 1, 0}, {0.4, 0, -0.5}});
      }
      const vec3 ahead(std::cos(angle), std::sin(angle), 0), v = size * speed * rotated(q, ahead);
      const int steps = static_cast<int>(0.05 / (speed * dt));
      const vec3 start = vec3(random.uniform(-1, 1) * 1e-3, random.uniform(-0.01, 0.01), 0.02) -
                         0.5 * steps * dt * speed * ahead;
      const auto roller =
          w.add(body{.shape = cylinder{0.02 * size, 0.05 * size},
                     .position = size * rotated(q, start),
                     .velocity = v,
                     .angular_velocity = rotated(q, vec3(0, 0, 1)).cross(v) / (0.02 * size),
                     .orientation = q * rotation({0, 0, 1}, angle) * rotation({1, 0, 0}, pi / 2)});
      real error = 0;
      for (int i = 0; i < steps; ++i) {
        w.step(dt);
        error = std::max(error, (w[roller].velocity() - v).norm() / v.norm());
      }
      CAPTURE(static_cast<int>(below));
      CAPTURE(k);
      CHECK(error < 1e-6);
    }
}
