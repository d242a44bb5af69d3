// A pile of 500 spheres in a box of planes: it settles, overlaps little, and gains no energy.
#include <doctest/doctest.h>

#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>

#include "../scenes/spheres_alone.hpp"

using namespace talus;
using heap = scenes::spheres_alone;

namespace {

constexpr real g = 9.81, dt = 1.0 / 240;

struct scene {
  serial::link link;
  world<heap> w{link};

  /// As PILE(512), less the last few sites.
  scene(const material& m, real weight = g) {
    const real side = 1.05 * 8;
    w.material(m);
    w.gravity({0, 0, -weight});
    w.seed(1);
    w.global([&](auto& s) {
      s.add(plane{.normal = {0, 0, 1}}, {});
      s.add(plane{.normal = {1, 0, 0}}, {});
      s.add(plane{.normal = {-1, 0, 0}, .offset = -side}, {});
      s.add(plane{.normal = {0, 1, 0}}, {});
      s.add(plane{.normal = {0, -1, 0}, .offset = -side}, {});
    });
    std::size_t made = 0;
    w.fill(simple_cubic{.spacing = 1.05, .origin = {0.525, 0.525, 0.6}} &
               box_region{{0, 0, 0}, {side, side, side}},
           [&](const site& at, random_stream& random) -> std::optional<body<sphere>> {
             if (made++ >= 500) return std::nullopt;
             return body{.shape = sphere{random.uniform(0.4, 0.5)},
                         .position = at.position + random.uniform(vec3(-0.02, -0.02, -0.02),
                                                                  vec3(0.02, 0.02, 0.02)),
                         .velocity = weight == 0 ? random.uniform(vec3(-3, -3, -3), vec3(3, 3, 3))
                                                 : vec3(0, 0, 0)};
           });
  }
};

}  // namespace

TEST_CASE(
    "a pile of 500 spheres comes to rest, overlaps by less than 5e-4, and never gains energy") {
  for (const real e : {0.0, 0.5}) {
    CAPTURE(e);
    scene s({.restitution = e, .friction = 0.5});
    const auto energy = [&] {
      const auto m = measure_motion(s.w);
      return m.kinetic_energy + m.potential_energy;
    };
    const motion start = measure_motion(s.w);
    const real unit = start.mass * g * 0.45;  // of a fall of all through a radius
    REQUIRE(start.bodies == 500);
    real lowest = energy(), gain = 0;
    for (int k = 0; k < 840; ++k) {
      s.w.step(dt);
      const real now = energy();
      gain = std::max(gain, now - lowest);
      lowest = std::min(lowest, now);
    }
    const auto m = measure_motion(s.w);
    const auto p = measure_penetration(s.w);
    MESSAGE("e ", e, ": kinetic energy ", m.kinetic_energy / unit, " of m g r, overlap mean ",
            p.mean, " max ", p.max, ", loaded |gap| ", p.gap_mean_loaded,
            ", largest gain of energy ", gain / unit);
    CHECK(m.kinetic_energy < 1e-2 * unit);
    CHECK(p.mean < 5e-4);
    CHECK(p.max < 1e-2);
    CHECK(gain < 1e-3 * unit);
    real below = 0;
    s.w.for_each_local(
        [&](const auto& b) { below = std::max(below, b.shape().radius - b.position()[2]); });
    CHECK(below < 5e-3);
  }
}

TEST_CASE(
    "without gravity or friction, elastic spheres in a box of planes keep their energy, others "
    "lose it") {
  for (const real e : {1.0, 0.8}) {
    CAPTURE(e);
    scene s({.restitution = e}, 0);
    const real start = measure_motion(s.w).kinetic_energy;
    real before = start, gain = 0;
    for (int k = 0; k < 480; ++k) {
      s.w.step(dt);
      const real now = measure_motion(s.w).kinetic_energy;
      gain = std::max(gain, now - before);
      before = now;
    }
    MESSAGE("e ", e, ": kinetic energy after 2 s ", before / start, ", largest gain in a step ",
            gain / start);
    CHECK(gain < 1e-2 * start);
    if (e == 1)
      CHECK(before == doctest::Approx(start).epsilon(0.1));
    else
      CHECK(before < 0.7 * start);
  }
}
