#pragma once
// Spheres that slide into a corner, on ranks whose cuts move again and again: the bits must be
// those of one rank.
#include <doctest/doctest.h>

#include <string>
#include <talus/observe/balance.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/bisection.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

namespace {

using namespace talus;

template <class Transport, class... Features>
using corner =
    scenario<bodies<sphere, plane>, solver<reproducible>, decomposition<bisection<dynamic>>,
             transport<Transport>, features<balancing, Features...>>;

struct corner_plan {
  const char* name;
  int steps = 130;
  std::uint64_t every = 0;  ///< steps between checks; 0: cuts never move
  balance_by by = balance_by::count;
  bool busy = false;   ///< bodies are added and removed, moved, fixed and released
  bool large = false;  ///< two of them are as large as domains
};

struct corner_end {
  std::string digest;
  load_balance shares;
};

template <class World>
void fill_corner(World& w, const corner_plan& plan) {
  w.gravity({5, 4, -7});
  w.material({.restitution = 0.1, .friction = 0.3});
  w.global([&](auto& s) {
    s.add(plane{.normal = {0, 0, 1}}, {});
    for (const double side : {-1.0, 1.0}) {
      s.add(plane{.normal = {side, 0, 0}, .offset = -4}, {});
      s.add(plane{.normal = {0, side, 0}, .offset = -4}, {});
    }
  });
  const auto sites =
      simple_cubic{.spacing = 0.8, .origin = {-3.6, -3.6, 0.5}} & vertical_cylinder{.radius = 3.4};
  w.fill(sites.first(300), [](const site& place, random_stream& random) {
    return body{.shape = sphere{random.uniform(0.2, 0.39)},
                .position = place.position,
                .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 0))};
  });
  if (plan.large) {
    w.add_if_local(body{.shape = sphere{1.6},
                        .position = {-2, -1.5, 8},
                        .velocity = {3, 2, -2},
                        .angular_velocity = {1, 5, 0}});
    w.add_if_local(body{.shape = sphere{1.2}, .position = {2, 2, 9}, .velocity = {-3, -3, -4}});
  }
  if constexpr (World::scenario_type::template has_feature<balancing>)
    if (plan.every > 0) w.balance({.every = plan.every, .above = 1.02, .by = plan.by});
}

/// Actions of a user between steps.
template <class World>
void tend_corner(World& w, int k) {
  if (k % 20 == 9) w.add_if_local(body{.shape = sphere{0.3}, .position = {0.02 * k - 3.5, 0.1, 6}});
  if (k % 60 == 29) w.destroy_if([](const auto& b) { return b.position()[2] > 5; });
  w.for_each_local([&](auto& b) {
    const auto hash = value_of(b.id()) % 7;
    if (k == 44 && hash == 0) b.translate({0.3, -0.1, 0.05});
    if (k == 50 && hash == 1) b.fix();
    if (k == 89 && b.is_fixed()) b.release();
    if (k == 104 && hash == 2) b.set_velocity({-8, 1, 3});
  });
}

template <class Scenario>
corner_end run_corner(typename Scenario::transport::link& link, const corner_plan& plan) {
  world<Scenario> w(link, {.lower = {-4, -4}, .upper = {4, 4}}, reach{plan.large ? 3.5 : 0.0});
  fill_corner(w, plan);
  for (int k = 0; k < plan.steps; ++k) {
    w.step(1.0 / 240);
    if (plan.busy) tend_corner(w, k);
  }
  (void)w.audit();
  return {state_digest(w), measure_balance(w)};
}

/// Each sequence of user actions, without moving cuts.
inline std::vector<corner_plan> courses() {
  return {{.name = "left alone", .steps = 160},
          {.name = "bodies come and go", .busy = true},
          {.name = "large bodies", .busy = true, .large = true}};
}
/// And with cuts that move.
inline std::vector<corner_plan> moving(const corner_plan& course) {
  corner_plan often = course, by_time = course;
  often.every = 5;
  by_time.every = 3, by_time.by = balance_by::time;
  return {often, by_time};
}

}  // namespace
