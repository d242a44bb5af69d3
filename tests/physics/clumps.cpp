// timeout: 300
// Grains of ten overlapping spheres settle in a box, on one and four ranks.
#include <doctest/doctest.h>

#include <cmath>
#include <mutex>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using clump = union_of<sphere>;
using heap = scenario<bodies<clump, plane>, solver<reproducible>,
                      decomposition<grid<dynamic, dynamic>>, transport<threads>>;

/// A sphere with nine smaller ones around it. Made anew for each grain: equal ones share their
/// data.
clump grain(real size) {
  std::vector<clump::part> parts{{.shape = sphere{0.5 * size}}};
  for (int k = 0; k < 9; ++k) {
    const real z = (2 * k + 1) / 9. - 1, turn = 2.4 * k, r = std::sqrt(1 - z * z);
    parts.push_back({.shape = sphere{0.32 * size},
                     .at = {0.4 * size * vec3(r * std::cos(turn), r * std::sin(turn), 1.3 * z)}});
  }
  return clump(parts);
}

struct outcome {
  std::string digest;
  motion moving;
  real overlap = 0;
};

outcome settle(int ranks) {
  outcome end;
  std::mutex mutex;
  threads::launch({.ranks = ranks}, [&](auto& link) {
    world<heap> w(link);
    const int across = ranks == 4 ? 2 : 1;
    w.decompose({.cells = {ranks / across, across}, .lower = {-3, -3}, .upper = {3, 3}});
    w.gravity({0, 0, -9.81});
    const auto stone = w.material({.density = 2.6, .restitution = 0, .friction = 0.5});
    w.global([&](auto& s) {
      s.add(plane{}, stone);
      for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        s.add(plane{.normal = n, .offset = -3}, stone);
    });
    w.fill(simple_cubic{.spacing = 1.5, .origin = {-2.25, -2.25, 0.9}} &
               box_region{{-3, -3, 0}, {3, 3, 9}},
           [&](const site& s, random_stream& random) {
             return body{.shape = grain(0.9 + 0.05 * static_cast<real>(random.integer(3))),
                         .position = s.position,
                         .material = stone,
                         .velocity = 0.3 * random.unit_vector(),
                         .orientation = random.rotation()};
           });
    for (int k = 0; k < 1200; ++k) w.step(1. / 240);
    const motion m = measure_motion(w);
    const auto overlap = measure_penetration(w);
    const std::string digest = state_digest(w);
    const std::lock_guard lock(mutex);
    if (link.rank() == 0) end = {digest, m, overlap.max};
  });
  return end;
}

}  // namespace

TEST_CASE("clumps of ten spheres settle in a box, alike on one and four ranks, with their mass") {
  const outcome one = settle(1), four = settle(4);
  CHECK(one.digest == four.digest);
  CHECK(one.moving.bodies == 96);
  // Lighter than their spheres, heavier than their largest one.
  const real volume = one.moving.mass / 2.6 / 96;
  real spheres = 0;
  grain(0.95).each_part([&](const sphere& s, const pose&) { spheres += s.volume(); });
  CHECK(volume < 0.8 * spheres);
  CHECK(volume == doctest::Approx(grain(0.95).volume()).epsilon(0.03));
  CHECK(one.moving.max_speed < 0.05);
  CHECK(one.overlap < 1e-3);
  // The walls of so small a box keep the packing loose.
  const real top = 2 * one.moving.potential_energy / (one.moving.mass * 9.81);
  const real filled = one.moving.mass / 2.6 / (36 * top);
  MESSAGE("speed ", one.moving.max_speed, ", overlap ", one.overlap, ", filled ", filled);
  CHECK(filled > 0.3);
  CHECK(filled < 0.7);
}
