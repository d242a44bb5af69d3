// The same bits on any number of ranks, for any decomposition: spheres.
#include "reproducible.hpp"

#include <mutex>
#include <set>
#include <talus/observe/residual.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/shape/box.hpp>
#include <tuple>

namespace {

template <class Solver>
using heap = scenario<bodies<sphere, plane>, solver<Solver>, transport<threads>,
                      decomposition<any_decomposition>>;

using monitored_heap = scenario<bodies<sphere, plane>, solver<reproducible>, transport<threads>,
                                decomposition<any_decomposition>, features<residual_monitor>>;

const auto spheres = [](auto& w) {
  const auto sites =
      simple_cubic{.spacing = 0.8, .origin = {-3.6, -3.6, 0.5}} & vertical_cylinder{.radius = 3.4};
  w.fill(sites.first(400), [](const site& place, random_stream& random) {
    return body{.shape = sphere{random.uniform(0.2, 0.39)},
                .position = place.position,
                .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0))};
  });
};
const auto nothing = [](auto&, int) {};

}  // namespace

TEST_CASE("a heap of spheres has the same bits on any ranks, while bodies come and go") {
  const auto come_and_go = [](auto& w, int k) {
    if (k % 40 == 20)
      w.add_if_local(body{.shape = sphere{0.3}, .position = {0.02 * k - 3.5, 0.1, 6}});
    if (k % 100 == 50) w.destroy_if([](const auto& b) { return b.position()[2] > 5; });
  };
  check_same<heap<reproducible>>(400, spheres, come_and_go);
}

TEST_CASE("a heap of spheres has the same bits where boxes are named before them") {
  using boxes_first = scenario<bodies<box, sphere, plane>, solver<reproducible>, transport<threads>,
                               decomposition<any_decomposition>>;
  check_same<boxes_first>(
      200,
      [](auto& w) {
        spheres(w);
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {1, 1, 6}});
      },
      nothing);
}

TEST_CASE("spheres that a shaking floor strikes have the same bits on any ranks") {
  using shaken = scenario<bodies<sphere, plane>, solver<reproducible>, transport<threads>,
                          decomposition<any_decomposition>, features<driven>>;
  check_same<shaken>(
      200,
      [](auto& w) {
        const auto elastic = w.material({.restitution = 0.5, .friction = 0.4});
        w.global([&](auto& scope) {
          w.drive(scope.add(plane{}, elastic),
                  oscillation{.amplitude = {0, 0, 0.1}, .frequency = 4});
        });
        spheres(w);
        w.add_if_local(body{.shape = sphere{1.2}, .position = {0, 0, 8}, .material = elastic});
      },
      nothing);
}

TEST_CASE("spheres as large as a domain, crossing several ranks, leave the bits the same") {
  check_same<heap<reproducible>>(
      300,
      [](auto& w) {
        spheres(w);
        w.add_if_local(body{.shape = sphere{1.6},
                            .position = {-2, -1.5, 8},
                            .velocity = {3, 2, -2},
                            .angular_velocity = {1, 5, 0}});
        w.add_if_local(body{.shape = sphere{1.2}, .position = {2, 2, 9}, .velocity = {-3, -3, -4}});
      },
      nothing);
}

TEST_CASE("asked for a tolerance, all find one residual to the bit, and stop after one iteration") {
  std::set<std::pair<std::uint64_t, double>> found;
  std::mutex mutex;
  check_same<heap<reproducible>>(
      60,
      [](auto& w) {
        w.solver().tolerance = 1e-5;
        w.solver().max_iterations = 300;
        spheres(w);
      },
      [&](auto& w, int k) {
        if (k < 59) return;
        const std::lock_guard lock(mutex);
        found.insert({w.convergence().iterations, w.convergence().residual});
      });
  CHECK(found.size() == 1);
}

TEST_CASE("the residual measured after the step has the same bits on any ranks") {
  std::set<std::tuple<double, double, double>> found;
  std::mutex mutex;
  check_same<monitored_heap>(60, spheres, [&](auto& w, int k) {
    if (k < 59) return;
    const contact_residual r = measure_residual(w);
    const std::lock_guard lock(mutex);
    found.insert({r.value, r.max, w.convergence().residual_worst});
  });
  CHECK(found.size() == 1);
}

TEST_CASE("a body added in the run where none was expected is met by the same contacts") {
  check_same<heap<reproducible>>(120, spheres, [](auto& w, int k) {
    if (k == 60)
      w.add_if_local(
          body{.shape = sphere{1.5}, .position = {0.3, 0.2, 3.2}, .velocity = {0, 0, -5}});
  });
}

TEST_CASE(
    "what a collision makes faster than anything else meets the same bodies in the next step") {
  const auto chain = [](double at, double next) {
    return [=](auto& w) {
      w.gravity({0, 0, 0});
      const auto heavy = w.material({.density = 1000, .restitution = 1, .friction = 0});
      const auto light = w.material({.density = 1, .restitution = 1, .friction = 0});
      const double speed = 0.3 * 0.5 * 240, start = at - 1 - 3.1 * speed / 240;
      for (const double x : {start, at, next})
        w.add_if_local(body{.shape = sphere{0.5},
                            .position = {x, 0.3, 2},
                            .material = x == start ? heavy : light,
                            .velocity = {x == start ? speed : 0, 0, 0}});
    };
  };
  for (const double at : {-0.35, -0.3})
    check_same<heap<reproducible>>(8, chain(at, at + 1.55), nothing);
}

TEST_CASE("what the user moves into another domain meets the bodies there in the next step") {
  check_same<heap<reproducible>>(
      40,
      [](auto& w) {
        w.add_if_local(body{.shape = sphere{0.5}, .position = {-2.1, 0.3, 0.5}});
        w.add_if_local(body{.shape = sphere{0.5}, .position = {2.5, 0.3, 0.5}});
      },
      [](auto& w, int k) {
        if (k != 20) return;
        w.for_each_local([](auto& b) {
          if (b.position()[0] < 0) b.translate({3.65, 0, 0.1});
        });
      });
}
