#pragma once
// --time-limit: a run ends by itself before a batch system ends it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "talus/core/clock.hpp"
#include "talus/observe/memory.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// The exit code of a run that its time limit has ended: EX_TEMPFAIL of sysexits.h, "try again".
inline constexpr int exit_code_of_time_limit = 75;

/// Says when the wall time of a run is over. Every 0.2 s the ranks agree, by one reduction, on the
/// time that has passed and on the step of their next agreement.
class time_limit {
 public:
  /// `start`: wall_seconds() when the program began; `writes`: a checkpoint is written at the end.
  time_limit(double seconds, double start, bool writes)
      : seconds_(seconds), start_(start), writes_(writes) {}

  /// Collective, after each step: whether the run must end with it.
  template <class Scenario>
  [[nodiscard]] bool over(const world<Scenario>& w, typename world<Scenario>::link_type& link) {
    if (seconds_ == 0 || over_ || w.steps() < next_) return over_;
    const double now = wall_seconds();
    const auto taken = static_cast<double>(std::max<std::uint64_t>(1, w.steps() - polled_at_));
    // The first agreement knows nothing about the time of a step.
    std::array<double, 3> most{now - start_, polls_ == 0 ? 0 : (now - polled_) / taken,
                               writes_ ? static_cast<double>(bytes_in_use(w)) * w.ranks() : 0};
    link.reduce(reduction::max, std::span<double>(most));
    polled_ = now, polled_at_ = w.steps();
    decide(most[0], most[1], most[2]);
    return over_;
  }

 private:
  [[gnu::cold]] void decide(double passed, double of_step, double bytes);

  double seconds_, start_, polled_ = 0;
  bool writes_, over_ = false;
  std::uint64_t polls_ = 0, polled_at_ = 0, next_ = 0;
  double between_ = 1;  ///< steps from the last agreement to the next
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/time_limit_definitions.hpp"
#endif
