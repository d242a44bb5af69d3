#pragma once
// features<continuous_collision>: its state, and the stage at which it acts
// (features/continuous_collision/continuous.hpp); detection (step/detect.hpp) follows flights to
// their first impact.
#include <limits>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/features/continuous_collision/continuous.hpp"
#include "talus/pairs/found_pairs.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"

namespace talus {
namespace detail {

/// Times of impact of bodies in the step under way; see
/// features/continuous_collision/continuous.hpp.
struct impact_times {
  plain_vector<real> time;  ///< of first impacts, in solver indices; infinite: no impact
  plain_vector<real> found;
  bool second_round = false;

  /// A body that stays at its impact for the rest of the step and that a driven body reaches moves
  /// on with the driven body.
  struct carried {
    real from = std::numeric_limits<real>::infinity();
    vec3 origin{0, 0, 0};  ///< the reference point of the driven body at the start of the step
    vec3 v{0, 0, 0}, w{0, 0, 0};
  };
  plain_vector<carried> carriers;  ///< in solver indices; empty if nothing is driven
};

}  // namespace detail

template <class Scenario>
struct continuous_collision::state {
  detail::impact_times impacts;
};

struct continuous_collision::hooks {
  /// Until when bodies continue after their impact.
  template <class Scenario>
  static void after_solve(detail::world_state<Scenario>& s) {
    timed(s, s.seconds.detect, [&] {
      limit_flights(s, [&] { detail::each_neighbour_pair<detail::flight_stopper>(s); });
    });
  }
};

}  // namespace talus
