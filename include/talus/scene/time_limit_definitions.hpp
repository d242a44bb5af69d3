#pragma once
// The definitions of time_limit.hpp, in the compiled part or in each program.
#include <algorithm>

#include "talus/core/linkage.hpp"
#include "talus/scene/time_limit.hpp"

namespace talus::detail {

TALUS_INLINE void time_limit::decide(double passed, double of_step, double bytes) {
  constexpr double between_polls = 0.2, most_steps = 1000, bytes_per_second = 50e6;
  // For the summary, and for a disk that is slower than most.
  const double reserve = std::min(5.0, 0.02 * seconds_) + bytes / bytes_per_second;
  const double left = seconds_ - reserve - passed;
  const double seconds = std::clamp(left / 2, 0.0, between_polls);
  // At most twice as far ahead as the last time: steps may become slower.
  const double steps = polls_ == 0 ? 1 : seconds / std::max(of_step, 1e-9);
  between_ = std::clamp(std::min(steps, 2 * between_), 1.0, most_steps);
  ++polls_;
  next_ = polled_at_ + static_cast<std::uint64_t>(between_);
  over_ = left <= between_ * of_step;
}

}  // namespace talus::detail
