// Light under heavy: stacks of ten with a heavy top, at the default settings. On one rank, and cut
// by four domains that meet in the middle of all bodies.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

#include "../scenes/alone.hpp"
#include "../scenes/solids.hpp"

using namespace talus;

namespace {

constexpr real dt = 1.0 / 240;

struct outcome {
  real drift = 0, penetration = 0, kinetic_energy = 0, weight = 0;
};

/// Ten boxes, or ten spheres in a shaft, the top one with `ratio` times the density. Boxes are
/// shifted by `aside` from the axis, to alternating sides.
template <class World>
outcome stack(World& w, real ratio, bool spheres, real time, real aside = 0) {
  const auto light = w.material({.density = 1, .friction = 0.5});
  const auto heavy = w.material({.density = ratio, .friction = 0.5});
  w.gravity({0, 0, -9.81});
  w.global([&](auto& scope) {
    scope.add(plane{}, light);
    if (spheres)
      for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        scope.add(plane{.normal = n, .offset = -0.5}, light);
  });
  for (int k = 0; k < 10; ++k) {
    const auto of = k == 9 ? heavy : light;
    if (spheres)
      w.add_if_local(body{.shape = sphere{0.5}, .position = {0, 0, k + 0.5}, .material = of});
    else
      w.add_if_local(body{.shape = box{{1, 1, 1}},
                          .position = {k % 2 ? aside : -aside, k % 4 < 2 ? aside : -aside, k + 0.5},
                          .material = of});
  }
  outcome worst;
  for (int step = 1; step * dt <= time; ++step) {
    w.step(dt);
    if (step % 60 == 0) worst.penetration = std::max(worst.penetration, measure_penetration(w).max);
  }
  w.for_each_local([&](const auto& b) {
    const vec3 p = b.position();
    const vec3 from(std::abs(p[0]) - (spheres ? 0 : aside), std::abs(p[1]) - (spheres ? 0 : aside),
                    p[2] - (std::floor(p[2]) + 0.5));
    worst.drift = std::max(worst.drift, from.norm());
  });
  w.link().reduce(reduction::max, std::span(&worst.drift, 1));
  const auto m = measure_motion(w);
  worst.kinetic_energy = m.kinetic_energy;
  worst.weight = m.mass * 9.81;
  CHECK(m.bodies == 10);
  return worst;
}

void judge(const outcome& r) {
  MESSAGE("drift ", r.drift, ", largest overlap ", r.penetration, ", kinetic energy ",
          r.kinetic_energy / r.weight, " m g");
  CHECK(r.drift < 1e-4);
  CHECK(r.penetration < 1e-4);
  CHECK(r.kinetic_energy < 1e-6 * r.weight);
}

}  // namespace

TEST_CASE("ten boxes and ten spheres stand for 5 s under a top of up to 1e6 times the density") {
  for (const bool spheres : {false, true})
    for (const real ratio : {1.0, 1e2, 1e3, 1e4, 1e6}) {
      CAPTURE(spheres);
      CAPTURE(ratio);
      serial::link link;
      world<scenes::alone> w(link);
      judge(stack(w, ratio, spheres, 5));
    }
}

TEST_CASE("a thousandfold top is borne where four domains meet in the middle of all bodies, too") {
  for (const bool spheres : {false, true})
    for (const real aside : {0.0, 0.01}) {
      if (spheres && aside > 0) continue;
      const real ratio = 1e3;
      CAPTURE(spheres);
      CAPTURE(aside);
      threads::launch({.ranks = 4}, [&](threads::link& link) {
        world<scenes::solids> w(link);
        w.decompose(grid<2, 2>{.lower = {-8, -8}, .upper = {8, 8}});
        const outcome r = stack(w, ratio, spheres, 5, aside);
        if (link.rank() == 0) judge(r);
      });
    }
}
