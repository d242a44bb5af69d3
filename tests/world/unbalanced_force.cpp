// The residual of soft contacts: the ratio of unbalanced force.
#include <doctest/doctest.h>

#include <cmath>
#include <mutex>
#include <set>
#include <talus/observe/monitors.hpp>
#include <talus/observe/residual.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/world/world.hpp>
#include <tuple>
#include <vector>

using namespace talus;

namespace {

using scene =
    scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot, coulomb_friction>,
             decomposition<grid<dynamic>>, transport<threads>, features<residual_monitor>>;

/// Runs `main(world)` on some ranks with a floor that has spheres in a row over it, each at the
/// height at which its contact bears `loads` of its weight.
template <class Main>
void on(int ranks, double loads, Main&& main) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene> w(link, {.cells = {ranks}, .lower = {0}, .upper = {16}});
    w.material({.density = 1, .restitution = 0.3, .friction = 0.5, .stiffness = 1e4});
    w.gravity({0, 0, -10});
    w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}}, {}); });
    const double mass = pi / 6;
    for (int k = 0; k < 15; ++k)
      w.add_if_local(
          body{.shape = sphere{0.5}, .position = {k + 1.0, 0, 0.5 - loads * 10 * mass / 1e4}});
    main(w);
  });
}

}  // namespace

TEST_CASE("it is what is left of the weight and the contact forces, over these, on any ranks") {
  for (const int ranks : {1, 2, 4})
    for (const double loads : {1.0, 2.0, 4.0}) {
      CAPTURE(ranks);
      CAPTURE(loads);
      on(ranks, loads, [&](auto& w) {
        w.synchronize();
        const contact_residual r = measure_residual(w);
        CHECK(r.contacts == 15);
        CHECK(r.value == doctest::Approx((loads - 1) / loads).epsilon(1e-6));
        CHECK(r.max == doctest::Approx((loads - 1) / loads).epsilon(1e-6));
      });
    }
}

TEST_CASE("it tends to 0 as bodies come to rest, and is 0 where nothing touches") {
  on(2, 3, [&](auto& w) {
    const auto run = [&](int steps) {
      for (int k = 0; k < steps; ++k) w.step(1e-4);
      return w.convergence().residual;
    };
    const double first = run(1), last = run(6000);
    CHECK(first > 0.5);
    CHECK(last < 1e-3);
    CHECK(w.convergence().residual_worst >= first);
    CHECK(measure_monitors(w).text.find("residual") != std::string::npos);
  });
  on(2, -100, [&](auto& w) {
    w.step(1e-4);
    CHECK(w.convergence().residual == 0);
    CHECK(measure_residual(w).contacts == 0);
  });
}

TEST_CASE("the monitor takes the forces that move the bodies in the step, on any ranks") {
  for (const int ranks : {1, 2, 4})
    for (const double loads : {1.0, 2.0, 4.0}) {
      CAPTURE(ranks);
      CAPTURE(loads);
      on(ranks, loads, [&](auto& w) {
        w.step(1e-3);
        CHECK(w.convergence().residual == doctest::Approx((loads - 1) / loads).epsilon(1e-9));
        // As measured at the start of the next step, but for the motion of springs in it.
        for (int k = 0; k < 20; ++k) {
          const double before = measure_residual(w).value;
          w.step(1e-6);
          CHECK(w.convergence().residual == doctest::Approx(before).epsilon(1e-3));
        }
      });
    }
}

TEST_CASE("its bits are those of one rank on any ranks, in the monitor and after the step") {
  std::set<std::tuple<double, double, double>> found;
  std::mutex mutex;
  for (const int ranks : {1, 2, 3, 4, 7})
    on(ranks, 2, [&](auto& w) {
      w.fill(simple_cubic{.spacing = 0.9, .origin = {0.6, -1.8, 1.2}} &
                 box_region{.lower = {0.1, -2, 0}, .upper = {15.9, 2, 4}},
             [](const site& place, random_stream& random) {
               return body{.shape = sphere{random.uniform(0.2, 0.45)},
                           .position = place.position,
                           .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0))};
             });
      for (int k = 0; k < 300; ++k) w.step(1e-3);
      const contact_residual r = measure_residual(w);
      const std::lock_guard lock(mutex);
      found.insert({w.convergence().residual, r.value, r.max});
      CHECK(r.contacts > 50);
    });
  CHECK(found.size() == 1);
}
