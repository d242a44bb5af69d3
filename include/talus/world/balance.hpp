#pragma once
// features<balancing>: how a world measures the shares of its ranks, and moves the cuts. The
// decomposition computes the cuts (parallel/bisection.hpp); synchronize() migrates all bodies, with
// the memory of their contacts.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/ghosts/shadow_copies.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/state/contact_count.hpp"
#include "talus/state/state.hpp"
#include "talus/step/step.hpp"

namespace talus::detail {

/// The load of one rank, and the reach of its bodies.
struct rank_load {
  double bodies = 0, contacts = 0, seconds = 0;
  real reach = 0;
};
/// The load of all ranks: its sum, and the largest values of a rank.
struct whole_load {
  rank_load sum, max;
  int ranks = 1;

  [[nodiscard]] imbalance uneven() const {
    const auto share = [&](double most, double all, double without) {
      return all > 0 ? most * ranks / all : without;
    };
    return {share(max.bodies, sum.bodies, 1), share(max.contacts, sum.contacts, unknown_share),
            share(max.seconds, sum.seconds, unknown_share)};
  }
};
/// Collective.
template <class Link>
[[nodiscard]] whole_load reduce_load(Link& link, const rank_load& mine) {
  std::array<double, 3> sums{mine.bodies, mine.contacts, mine.seconds};
  std::array<double, 4> most{mine.bodies, mine.contacts, mine.seconds, mine.reach};
  link.reduce(reduction::sum, std::span<double>(sums));
  link.reduce(reduction::max, std::span<double>(most));
  return {{sums[0], sums[1], sums[2], 0}, {most[0], most[1], most[2], most[3]}, link.size()};
}

/// Cost of a body here, 1 for the mean one of all ranks: half of the old value and half of the new
/// one, because times scatter. A rank without bodies has no value.
inline constexpr double most_uneven_cost = 32;
[[nodiscard]] inline double cost_of_body(double before, const rank_load& mine,
                                         const whole_load& all) {
  if (!(mine.bodies > 0) || !(all.sum.seconds > 0)) return before;
  const double now = mine.seconds / mine.bodies / (all.sum.seconds / all.sum.bodies);
  return 0.5 * (before + std::clamp(now, 1 / most_uneven_cost, most_uneven_cost));
}
/// Weights are whole numbers, so that their sums do not depend on their distribution over ranks.
[[nodiscard]] inline std::uint64_t weight_of_cost(double cost) {
  return static_cast<std::uint64_t>(4096 * cost);
}

/// Copies are needed as far as the reaches of two bodies that touch, with a margin for bodies that
/// become faster until cuts move again.
inline constexpr real room_for_reach = 1.25;
[[nodiscard]] inline real reach_of_connections(real largest_reach, real asked) {
  return std::max(asked, 2 * room_for_reach * largest_reach);
}

/// Throws invalid_argument for settings out of range.
[[gnu::cold]] inline void require_sane(const balance_settings& how) {
  if (how.every < 1 || !(how.above >= 1) || !std::isfinite(how.above))
    fail<std::invalid_argument>(
        "cuts are checked every so many steps, 1 or more, and move above a largest share over "
        "the "
        "mean one of 1 or more, but these are {} and {}",
        how.every, how.above);
}

/// The load of this rank: its bodies, the contacts of its last step, and its time.
template <class Scenario>
[[nodiscard]] rank_load load_of(const world_state<Scenario>& s, double seconds) {
  rank_load mine{.contacts = static_cast<double>(count_contacts(s)), .seconds = seconds};
  s.each_finite_shape([&](const auto& b) {
    mine.bodies += static_cast<double>(b.movable.locals);
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      mine.reach = std::max(mine.reach, shadow_reach(s, b.movable, i));
  });
  return mine;
}

/// Positions of the bodies owned here.
template <class Scenario>
[[nodiscard]] plain_vector<vec3> places_of_own(const held_bodies<Scenario>& s) {
  plain_vector<vec3> places;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i) places.push_back(b.movable.position[i]);
  });
  return places;
}

/// Counts collective calls during its lifetime.
template <class Scenario>
class collectives_counted {
 public:
  explicit collectives_counted(world_state<Scenario>& s) : s_(s) {}
  collectives_counted(const collectives_counted&) = delete;
  collectives_counted& operator=(const collectives_counted&) = delete;
  ~collectives_counted() { s_.sent.collectives += s_.link->counters().collectives - before_; }

 private:
  world_state<Scenario>& s_;
  std::uint64_t before_ = s_.link->counters().collectives;
};

/// A step, and the time that this rank worked in it.
template <class Scenario>
void step_with_clock(world_state<Scenario>& s, real dt) {
  const double began = thread_seconds(), exchanged = s.seconds.exchange.processor;
  step(s, dt);
  const double worked = thread_seconds() - began - (s.seconds.exchange.processor - exchanged);
  s.balance.seconds += worked;
  s.balance.since_move += worked;
}

}  // namespace talus::detail
