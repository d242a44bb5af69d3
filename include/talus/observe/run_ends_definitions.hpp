#pragma once
// The definitions of run_ends.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/observe/run_ends.hpp"

namespace talus::detail {

TALUS_INLINE void require_sane(const rest& how) {
  if (!(how.speed >= 0 && how.time >= 0) || !std::isfinite(how.speed) || !std::isfinite(how.time))
    fail<std::invalid_argument>(
        "bodies are at rest below a speed and after a time, both finite and not negative, but they "
        "are {} and {}",
        how.speed, how.time);
}

TALUS_INLINE void require_gravity(real gravity) {
  if (gravity == 0)
    fail<std::invalid_argument>(
        "without gravity nothing says what is slow: give at_rest a speed and a time (--until-speed "
        "and --until-time), or set gravity");
}

TALUS_INLINE void require_sane(const steadiness& how) {
  if (!(how.time > 0 && how.within > 0) || !std::isfinite(how.time) || !std::isfinite(how.within))
    fail<std::invalid_argument>(
        "an observable is steady over a time and within a part of its size, both finite and "
        "positive, but they are {} and {} (--until-time and --until-within)",
        how.time, how.within);
}

TALUS_INLINE bool end_watch::rests(bool slow, real now, real time) {
  if (!slow) quiet_since_ = -1;
  if (slow && quiet_since_ < 0) quiet_since_ = now;
  return slow && now - quiet_since_ >= time;
}

TALUS_INLINE bool end_watch::take(real time, real value) {
  if (!std::isfinite(value))
    fail<std::runtime_error>(
        "the observable that is to become steady is {} at the time {}: it must be finite", value,
        time);
  times_.push_back(time), values_.push_back(value);
  if (time - times_[0] < how_.time) return false;
  std::size_t first = 0;  // the last value that is as old as the window
  while (first + 1 < times_.size() && time - times_[first + 1] >= how_.time) ++first;
  real means[2] = {}, size = 0;
  std::size_t counts[2] = {};
  const real middle = 0.5 * (times_[first] + time);
  for (std::size_t k = first; k < times_.size(); ++k) {
    const std::size_t half = times_[k] < middle ? 0 : 1;
    means[half] += values_[k], ++counts[half];
    size += std::abs(values_[k]);
  }
  if (first > values_.size() / 2) {  // what is older is forgotten now and then
    const std::size_t kept = values_.size() - first;
    for (std::size_t k = 0; k < kept; ++k)
      times_[k] = times_[first + k], values_[k] = values_[first + k];
    times_.resize(kept), values_.resize(kept);
  }
  constexpr std::size_t fewest = 3;  // values in a half
  if (counts[0] < fewest || counts[1] < fewest) return false;
  size /= static_cast<real>(counts[0] + counts[1]);
  for (int half = 0; half < 2; ++half) means[half] /= static_cast<real>(counts[half]);
  return std::abs(means[1] - means[0]) <= how_.within * size;
}

}  // namespace talus::detail
