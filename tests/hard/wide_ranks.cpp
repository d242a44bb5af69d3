// timeout: 300
// Wide heavy loads on light bodies of several ranks, at the default settings.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/force.hpp>
#include <talus/observe/islands.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <type_traits>

using namespace talus;

namespace {

constexpr real dt = 0.005;

struct load {
  int ranks = 4;
  int side = 10;       ///< light bodies in a row
  real density = 1e4;  ///< of the plates; light bodies have 1
  real time = 0.5;
  int plates = 1;  ///< each on a layer of light bodies
  bool boxes = false;
  real push = 0;        ///< speed of the topmost plate along x at first
  real lowest = 1e-8;   ///< by which the top may have moved up or down
  real balance = 1e-5;  ///< of the force on the floor in one step, as part of the weight
};

template <class Number = double>
void hold(const load& l) {
  using scene = scenario<bodies<box, sphere, plane>, transport<threads>, precision<Number>,
                         decomposition<grid<dynamic, dynamic>>, features<momentum_balance>>;
  CAPTURE(l.ranks);
  CAPTURE(l.side);
  CAPTURE(l.density);
  threads::launch({.ranks = l.ranks}, [&](threads::link& link) {
    world<scene> w(link);
    const real half = 0.5 * l.side, edge = half + 1;
    w.decompose({.lower = {-edge, -edge}, .upper = {edge, edge}}, {.distance = half + 1});
    const auto light = w.material({.density = 1, .friction = 0.5});
    const auto heavy = w.material({.density = l.density, .friction = 0.5});
    w.gravity({0, 0, -9.81});
    handle<plane> floor;
    w.global([&](auto& scope) { floor = scope.add(plane{}, light); });
    for (int k = 0; k < l.plates; ++k) {
      for (int i = 0; i < l.side; ++i)
        for (int j = 0; j < l.side; ++j) {
          const vec3 at{i + 0.5 - half, j + 0.5 - half, 2 * k + 0.5};
          if (l.boxes)
            w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = at, .material = light});
          else
            w.add_if_local(body{.shape = sphere{0.5}, .position = at, .material = light});
        }
      // Shifted, so that plates belong to different ranks.
      w.add_if_local(body{.shape = box{{2 * half, 2 * half, 1}},
                          .position = {k % 2 == 0 ? 0.01 : -0.01, 0.01, 2 * k + 1.5},
                          .material = heavy,
                          .velocity = {k + 1 == l.plates ? l.push : 0, 0, 0}});
    }
    const real top = 2 * l.plates - 0.5;
    real highest = 0, lowest = 0;
    for (int step = 1; step * dt <= l.time + dt / 2; ++step) {
      w.step(dt);
      w.for_each_local([&](const auto& b) {
        if (b.position()[2] < top - 0.9) return;
        highest = std::max(highest, b.position()[2] - top);
        lowest = std::min(lowest, b.position()[2] - top);
      });
    }
    const real weight = measure_motion(w).mass * 9.81;
    const real borne = std::abs(contact_force(w, floor)[2]) / weight;
    const islands_solved found = measure_islands(w);
    const momentum_account momentum = measure_momentum(w);
    link.reduce(reduction::max, std::span(&highest, 1));
    link.reduce(reduction::min, std::span(&lowest, 1));
    const real overlap = measure_penetration(w).max;
    if (link.rank() != 0) return;
    MESSAGE(l.side * l.side, " on ", l.ranks, " ranks under density ", l.density, ": lowered by ",
            -lowest, ", floor bears ", borne, " of the weight");
    CHECK(-lowest < l.lowest);
    CHECK(highest < l.lowest);
    CHECK(std::abs(borne - 1) < l.balance);
    CHECK(overlap < 10 * l.lowest);
    CHECK(found.skipped == 0);
    CHECK(momentum.error() < (std::is_same_v<Number, double> ? 1e-10 : 1e-6));
  });
}

}  // namespace

TEST_CASE("a box of up to 1e4 times the density stands still on spheres of 2 to 6 ranks") {
  for (const int ranks : {2, 4, 6})
    for (const real density : {1e2, 1e4}) hold({.ranks = ranks, .density = density});
  hold({.side = 10, .time = 3});
  hold({.side = 24});
}

TEST_CASE("2,500 spheres of four ranks hold under a box of density 1e4") {
  hold({.side = 50, .time = 0.05});
}

TEST_CASE("light boxes, and layers between plates of several ranks, hold too") {
  hold({.side = 8, .boxes = true});
  hold({.side = 10, .plates = 3});
}

TEST_CASE("two plates of outer ranks hold on a bed that joins them on the rank between") {
  using scene = scenario<bodies<box, sphere, plane>, transport<threads>,
                         decomposition<grid<dynamic>>, features<momentum_balance>>;
  const auto lowered = [](real x_of_plates, real width) {
    real lowest = 0;
    threads::launch({.ranks = 3}, [&](threads::link& link) {
      world<scene> w(link);
      w.decompose({.lower = {-15}, .upper = {15}}, {.distance = 7});
      const auto light = w.material({.density = 1, .friction = 0.5});
      const auto heavy = w.material({.density = 1e4, .friction = 0.5});
      w.gravity({0, 0, -9.81});
      w.global([&](auto& scope) { scope.add(plane{}, light); });
      for (int i = 0; i < 28; ++i)
        for (int j = 0; j < 12; ++j)
          w.add_if_local(
              body{.shape = sphere{0.5}, .position = {i - 13.5, j - 5.5, 0.5}, .material = light});
      for (const real x : {-x_of_plates, x_of_plates})
        w.add_if_local(
            body{.shape = box{{width, 12, 1}}, .position = {x, 0.01, 1.5}, .material = heavy});
      real low = 0;
      for (int k = 0; k < 100; ++k) {
        w.step(dt);
        w.for_each_local([&](const auto& b) {
          if (b.position()[2] > 0.9) low = std::min(low, b.position()[2] - 1.5);
        });
      }
      link.reduce(reduction::min, std::span(&low, 1));
      CHECK(measure_islands(w).skipped == 0);
      if (link.rank() == 0) lowest = low;
    });
    return -lowest;
  };
  // The part of a plate over the spheres of its own rank differs.
  CHECK(lowered(5.6, 10.8) < 1e-6);
  CHECK(lowered(6, 11.6) < 1e-6);
  CHECK(lowered(6.2, 12) < 1e-6);
}

TEST_CASE("a plate that is pushed slides on spheres of four ranks without falling") {
  hold({.side = 10, .time = 0.2, .push = 0.1, .lowest = 1e-6, .balance = 1e-2});
}

TEST_CASE("contacts solved in float hold a wide load of four ranks to the round-off of floats") {
  hold<mixed_precision>({.side = 10, .lowest = 1e-5, .balance = 1e-2});
}
