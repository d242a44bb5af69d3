// Walls that are held at a force confine a packing, and floors bear the bodies on them.
// long
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/force.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class Law>
using scene = scenario<bodies<sphere, plane>, Law, transport<threads>,
                       decomposition<grid<dynamic, dynamic>>, features<driven>>;

/// A packing under a lid that presses with `force`: the load on the lid and the floor, as the mean
/// over the last quarter of the steps.
template <class Law>
void confine(int ranks, real force, real g, int steps, real dt) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene<Law>> w(link, {.lower = {0, 0}, .upper = {5, 5}});
    w.gravity({0, 0, -g});
    const auto grain = w.material({.density = 2, .friction = 0.3, .stiffness = 2e4});
    const auto smooth = w.material({.density = 2, .stiffness = 2e4});
    w.material_pair(grain, smooth, {});
    handle<plane> lid, floor;
    w.global([&](auto& s) {
      floor = s.add(plane{}, smooth);
      lid = s.add(plane{.normal = {0, 0, -1}, .offset = -8}, smooth);
      s.add(plane{.normal = {1, 0, 0}, .offset = 0}, smooth);
      s.add(plane{.normal = {-1, 0, 0}, .offset = -5}, smooth);
      s.add(plane{.normal = {0, 1, 0}, .offset = 0}, smooth);
      s.add(plane{.normal = {0, -1, 0}, .offset = -5}, smooth);
    });
    real weight = 0;
    w.fill(simple_cubic{.spacing = 1, .origin = {0.5, 0.5, 0.5}} &
               box_region{{0.4, 0.4, 0.4}, {4.6, 4.6, 6}},
           [&](const site& place, random_stream& random) {
             const real r = random.uniform(0.35, 0.5);
             weight += g * 2 * r * r * r * 4 / 3 * pi;
             return body{.shape = sphere{r},
                         .position = place.position,
                         .material = grain,
                         .velocity = random.uniform(vec3(-3, -3, -3), vec3(3, 3, 3))};
           });
    w.link().reduce(reduction::sum, std::span(&weight, 1));
    w.hold_force(lid, {.force = force, .max_speed = 1});
    real on_lid = 0, on_floor = 0, worst = 0, looks = 0;
    for (int k = 0; k < steps; ++k) {
      w.step(dt);
      // Asked again for the same, as in each stage of a run, it goes on pressing.
      if (k > steps / 2 && k % 50 == 0) w.hold_force(lid, {.force = force, .max_speed = 1});
      if (k < steps * 3 / 4 || k % 10 != 0) continue;
      ++looks;
      const real now = contact_force(w, lid)[2];
      on_lid += now, on_floor -= contact_force(w, floor)[2];
      worst = std::max(worst, std::abs(now - force));
    }
    on_lid /= looks, on_floor /= looks;
    const double overlap = measure_penetration(w).max;
    if (w.rank() != 0) return;
    MESSAGE("lid " << on_lid << " of " << force << " (worst " << worst << "), floor " << on_floor
                   << " of " << force + weight << ", overlap " << overlap);
    CHECK(on_lid == doctest::Approx(force).epsilon(0.03));
    CHECK(on_floor == doctest::Approx(force + weight).epsilon(0.03));
    CHECK(overlap < 0.1);  // under 25 times the weight
  });
}

}  // namespace

TEST_CASE("a lid presses on rigid grains as it is told") {
  confine<hard_contact<coulomb_friction>>(1, 500, 10, 3000, 0.005);
  confine<hard_contact<coulomb_friction>>(1, 5000, 10, 3000, 0.005);
  confine<hard_contact<coulomb_friction>>(4, 500, 0, 3000, 0.005);
}

TEST_CASE("and on soft ones") {
  confine<soft_contact<linear_spring_dashpot, coulomb_friction>>(1, 500, 10, 22000, 0.0005);
}
