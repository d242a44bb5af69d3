#pragma once
// The path of every body of a small scene, on any number of ranks in this process.
#include <cstddef>
#include <map>
#include <mutex>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <tuple>
#include <vector>

namespace talus::validation {

/// One body at one time.
struct moment {
  vec3 position, velocity, angular_velocity;
  quat orientation;
};
/// By body, in the order in which they were added, then by step: the start, then after each step.
using tracks = std::vector<std::vector<moment>>;

/// Runs `steps` steps of a scene that set_up(world) makes with add_if_local, on 1 rank or on 4
/// whose domains meet at x = y = 0. If after_step is given, after_step(world) is called on every
/// rank. Throws runtime_error unless each body has exactly one owner at all times.
template <class Scenario, class SetUp, class AfterStep>
tracks follow(int ranks, real dt, std::size_t steps, SetUp&& set_up, AfterStep&& after_step) {
  std::map<system_id, std::vector<moment>> ways;
  std::size_t count = 0;
  std::mutex one_by_one;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, grid<dynamic, dynamic>{});
    set_up(w);
    std::vector<std::tuple<system_id, std::size_t, moment>> seen;
    const auto look = [&](std::size_t step) {
      w.for_each_local([&](const auto& b) {
        if (!b.is_fixed())
          seen.emplace_back(
              b.id(), step,
              moment{b.position(), b.velocity(), b.angular_velocity(), b.orientation()});
      });
    };
    look(0);
    for (std::size_t k = 1; k <= steps; ++k) {
      w.step(dt);
      look(k);
      after_step(w);
    }
    const std::lock_guard lock(one_by_one);
    count += seen.size();
    for (const auto& [id, step, m] : seen) {
      ways[id].resize(steps + 1);
      ways[id][step] = m;
    }
  });
  if (count != ways.size() * (steps + 1))
    throw std::runtime_error("a body was lost, or had two owners");
  tracks all;
  for (auto& [id, way] : ways) all.push_back(std::move(way));
  return all;
}
template <class Scenario, class SetUp>
tracks follow(int ranks, real dt, std::size_t steps, SetUp&& set_up) {
  return follow<Scenario>(ranks, dt, steps, set_up, [](auto&) {});
}

}  // namespace talus::validation
