#pragma once
// Runs a small scene on one rank or across the boundaries of several, and returns the results.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <vector>

namespace talus::hard {

using cuts = grid<dynamic, dynamic, dynamic>;

/// All scenes of these tests: bodies of some shapes, the default law, solver and settings.
template <class... Shapes>
using scene =
    scenario<bodies<Shapes...>, transport<threads>, decomposition<grid<dynamic, dynamic, dynamic>>>;

/// The motion of one body.
struct way {
  pose start, end;
  vec3 velocity{0, 0, 0}, angular_velocity{0, 0, 0};
  real furthest = 0;  ///< from where it started, at any step
  real fastest = 0;   ///< any point of it, at any step
};

struct outcome {
  std::vector<way> bodies;  ///< that can move, in the order in which they were added
  motion before, after;
  penetration overlap;      ///< at the end
  real deepest = 0;         ///< largest overlap at any check, over the mean bounding radius
  real highest_energy = 0;  ///< kinetic and potential, the largest at any check
  bool finite = true;
  std::uint64_t contacts = 0;  ///< that carry an impulse at the end

  [[nodiscard]] real furthest() const {
    real most = 0;
    for (const way& b : bodies) most = std::max(most, b.furthest);
    return most;
  }
  [[nodiscard]] real fastest() const {
    real most = 0;
    for (const way& b : bodies) most = std::max(most, b.fastest);
    return most;
  }
  /// Largest distance of a body from where it started, at the end.
  [[nodiscard]] real drift() const {
    real most = 0;
    for (const way& b : bodies) most = std::max(most, (b.end.position - b.start.position).norm());
    return most;
  }
  [[nodiscard]] real mass() const { return after.mass; }
};

/// Bound of the speed that rotation adds to a point of a body.
template <class Body>
real surface_speed(const Body& b) {
  const vec3 w = (b.orientation().conjugate() * b.angular_velocity()).cwiseAbs();
  const vec3 half = b.shape().half_extents(pose{});
  return vec3(w[1] * half[2] + w[2] * half[1], w[2] * half[0] + w[0] * half[2],
              w[0] * half[1] + w[1] * half[0])
      .norm();
}

/// Makes a world on each rank of `domains`, calls set_up(world) to add bodies with add_if_local,
/// and makes `steps` steps; measures overlaps and energy every `every` steps.
template <class Scenario>
outcome run(const cuts& domains, real dt, int steps,
            const std::function<void(world<Scenario>&)>& set_up, int every = 60) {
  outcome result;
  std::map<system_id, way> ways;
  std::mutex one_by_one;
  const int ranks = std::max(1, domains.size());
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, domains);
    set_up(w);
    w.synchronize();
    {
      const std::lock_guard lock(one_by_one);
      w.for_each_local([&](const auto& b) {
        if (b.is_fixed()) return;
        way& mine = ways[b.id()];
        mine.start = b.pose();
      });
    }
    link.barrier();
    const auto look = [&] {
      const motion m = measure_motion(w);
      const penetration p = measure_penetration(w);
      if (link.rank() != 0) return;
      if (result.before.bodies == 0) {
        result.before = m;
        result.highest_energy = m.kinetic_energy + m.potential_energy;
      }
      result.after = m;
      result.overlap = p;
      result.deepest = std::max(result.deepest, p.max);
      result.highest_energy =
          std::max(result.highest_energy, m.kinetic_energy + m.potential_energy);
    };
    look();
    for (int k = 1; k <= steps; ++k) {
      w.step(dt);
      w.for_each_local([&](const auto& b) {
        if (b.is_fixed()) return;
        way& mine = ways.find(b.id())->second;  // one rank at a time owns it
        mine.furthest = std::max(mine.furthest, (b.position() - mine.start.position).norm());
        mine.fastest = std::max(mine.fastest, b.velocity().norm() + surface_speed(b));
      });
      if (k % every == 0 || k == steps) look();
    }
    const std::lock_guard lock(one_by_one);
    w.for_each_local([&](const auto& b) {
      if (b.is_fixed()) return;
      way& mine = ways[b.id()];
      mine.end = b.pose();
      mine.velocity = b.velocity();
      mine.angular_velocity = b.angular_velocity();
      result.finite = result.finite && b.position().allFinite() && b.velocity().allFinite() &&
                      b.angular_velocity().allFinite() && std::isfinite(b.orientation().norm());
    });
    for (const auto& c : talus::detail::state_of(w).history.entries())
      result.contacts += c.memory.norm() > 0;
  });
  for (const auto& [id, way] : ways) result.bodies.push_back(way);
  return result;
}

}  // namespace talus::hard
