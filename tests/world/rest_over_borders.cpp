// Few bodies stay at rest on each other where borders of ranks pass through them.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/cylinder.hpp>
#include <talus/shape/plane.hpp>
#include <talus/solver/nonlinear_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <utility>

using namespace talus;

namespace {

using scene = scenario<bodies<box, cylinder, plane>, decomposition<grid<dynamic, dynamic>>,
                       transport<threads>, features<checkpoints>>;

struct course {
  real size = 1, dt = 1.0 / 60;
  int before = 1, after = 0;  ///< ranks before a restart after half a second and after it, or 0
  bool tiles = false;         ///< fixed boxes, which are bodies of their ranks, or a plane
  real friction = 0.5;
};
struct builder {
  world<scene>& w;
  const course& c;

  void stand(const vec3& at, real radius, real height) {
    w.add_if_local(body{.shape = cylinder{c.size * radius, c.size * height},
                        .position = c.size * (at + vec3(0, 0, height / 2))});
  }
  void lie(const vec3& at, real radius, real length, real turn) {
    w.add_if_local(body{.shape = cylinder{c.size * radius, c.size * length},
                        .position = c.size * (at + vec3(0, 0, radius)),
                        .orientation = rotation({0, 0, 1}, turn) * rotation({1, 0, 0}, pi / 2)});
  }
  void put(const vec3& at, const vec3& sides) {
    w.add_if_local(body{.shape = box{vec3(c.size * sides)}, .position = c.size * at});
  }
  void ground(bool restarts) {
    if (!c.tiles) return w.global([&](auto& scope) { scope.add(plane{}, {}); });
    if (restarts) return;
    for (int i = -2; i < 2; ++i)
      for (int j = -2; j < 2; ++j)
        w.add_if_local(body<box>{.shape = box{vec3(c.size * vec3(2, 2, 0.5))},
                                 .position = c.size * vec3(2 * i + 1.1, 2 * j + 1.07, -0.25),
                                 .fixed = true});
  }
};

/// The longest way of a body in two seconds, over the size.
template <class Put>
real way(const course& c, Put&& put) {
  const std::string file = "/tmp/talus_rest_over_borders_" + std::to_string(getpid()) + ".h5";
  std::map<system_id, vec3> start;
  std::mutex mutex;
  real longest = 0;
  const auto run = [&](int ranks, bool restarts, real seconds) {
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      const real l = 4 * c.size;
      world<scene> w(
          link,
          {.cells = {std::min(ranks, 2), ranks == 4 ? 2 : 1}, .lower = {-l, -l}, .upper = {l, l}});
      w.gravity({0, 0, -9.81});
      w.material({.density = 1000, .restitution = 0, .friction = c.friction});
      builder b{w, c};
      b.ground(restarts);
      if (restarts)
        read_checkpoint(w, file);
      else
        put(b);
      const int steps = static_cast<int>(std::lround(seconds / c.dt));
      for (int k = 0; k <= steps; ++k) {
        if (k > 0) w.step(c.dt);
        const std::lock_guard lock(mutex);
        w.for_each_local([&](const auto& one) {
          const auto [at, is_new] = start.emplace(one.id(), one.position());
          longest = std::max(longest, (one.position() - at->second).norm() / c.size);
        });
      }
      if (!restarts && c.after > 0) write_checkpoint(w, file);
    });
  };
  run(c.before, false, c.after > 0 ? 0.5 : 2);
  if (c.after > 0) run(c.after, true, 1.5), unlink(file.c_str());
  return longest;
}

/// On any ranks, with a restart on others and without one.
template <class Put>
void check_rest(Put&& put, real friction = 0.5) {
  for (const bool tiles : {false, true})
    for (const auto& [size, dt] : {std::pair{1.0, 1.0 / 60}, {0.05, 1.0 / 60}, {0.05, 1.0 / 240}})
      for (const auto& [before, after] : {std::pair{1, 0}, {2, 0}, {4, 0}, {2, 4}, {4, 1}}) {
        const course c{size, dt, before, after, tiles, friction};
        CAPTURE(friction);
        CAPTURE(tiles);
        CAPTURE(size);
        CAPTURE(dt);
        CAPTURE(before);
        CAPTURE(after);
        CHECK(way(c, put) < 1e-7);
      }
}

}  // namespace

TEST_CASE("a slab on three standing cylinders stays at rest on any ranks and over restarts") {
  check_rest([](builder& b) {
    const vec3 middle(0.1, 0, 0);
    for (int k = 0; k < 3; ++k) {
      const real turn = 1.9216 + 2 * pi * k / 3;
      b.stand(middle + 0.6 * vec3(std::cos(turn), std::sin(turn), 0), 0.2, 0.6);
    }
    b.put(middle + vec3(-0.093, 0.254, 0.75), {2, 2, 0.3});
  });
}

TEST_CASE("a slab on three lying cylinders stays at rest on any ranks and over restarts") {
  check_rest([](builder& b) {
    const vec3 middle(-0.25, 0.2, 0);
    for (int k = 0; k < 3; ++k) {
      const real turn = 0.85 + 2 * pi * k / 3;
      b.lie(middle + 0.6 * vec3(std::cos(turn), std::sin(turn), 0), 0.2, 0.6, turn + 0.4);
    }
    b.put(middle + vec3(0.16, 0.18, 0.55), {2, 2, 0.3});
  });
}

TEST_CASE("a box near the rim of a standing cylinder stays there on any ranks and over restarts") {
  for (const real part : {0.6, 0.9}) {
    CAPTURE(part);
    check_rest([&](builder& b) {
      b.stand({-0.05, 0.03, 0}, 0.5, 1);
      b.put(vec3(-0.05, 0.03, 1.15) + 0.5 * part * vec3(std::cos(0.4), std::sin(0.4), 0),
            {1.5, 1.5, 0.3});
    });
  }
}

TEST_CASE("with much friction, it stays there too, though contacts on their cones could open") {
  for (const real turn : {0.4, 2.0, 4.4})
    check_rest(
        [&](builder& b) {
          b.stand({-0.05, 0.03, 0}, 0.5, 0.8);
          const vec3 shift = 0.4 * vec3(std::cos(turn), std::sin(turn), 0);
          b.put(vec3(-0.05, 0.03, 0.95) + shift, {1.5, 1.3, 0.3});
        },
        3);
}

TEST_CASE("a box on a slab on four columns stays at rest on any ranks and over restarts") {
  check_rest([](builder& b) {
    for (const real x : {-0.5, 0.7})
      for (const real y : {-0.7, 0.5}) b.stand({x, y, 0}, 0.2, 0.6);
    b.put({0.1, -0.1, 0.75}, {2, 2, 0.3}), b.put({0.4, 0.2, 1.05}, {1, 1, 0.3});
  });
}
