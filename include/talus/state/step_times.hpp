#pragma once
// Times of single steps of a run: the mean says little where a few steps take long.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/core/clock.hpp"

namespace talus {

/// CPU time of the steps of a run, in seconds, on the slowest rank; without functions of the
/// program and outputs.
struct step_seconds {
  double median = 0;
  double p99 = 0;  ///< 99 of 100 steps take at most this
  double longest = 0;
  std::uint64_t slowest_step = 0;  ///< the number of the longest step
};

namespace detail {

/// Counts steps by their time, in bins of 4.4 % (sixteen to an octave).
class step_times {
 public:
  void add(double seconds, std::uint64_t step) {
    if (seconds > longest_) longest_ = seconds, slowest_ = step;
    const double octaves = std::log2(std::max(seconds, least)) - std::log2(least);
    const auto bin = static_cast<std::size_t>(octaves * per_octave);
    ++bins_[std::min(bin, bins_.size() - 1)];
    ++steps_;
  }
  /// The time that a part of the steps does not exceed, to 2.2 %.
  [[nodiscard]] double quantile(double part) const {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(part * static_cast<double>(steps_)));
    std::uint64_t counted = 0;
    for (std::size_t k = 0; k < bins_.size(); ++k) {
      counted += bins_[k];
      if (counted >= wanted && counted > 0)
        return std::min(longest_, least * std::exp2((static_cast<double>(k) + 0.5) / per_octave));
    }
    return longest_;
  }
  /// Makes a step and counts its time.
  template <class Step>
  void measure(std::uint64_t number, Step&& step) {
    const double began = thread_seconds();
    step();
    add(thread_seconds() - began, number);
  }
  [[nodiscard]] step_seconds found() const {
    return {quantile(0.5), quantile(0.99), longest_, slowest_};
  }

 private:
  static constexpr double least = 1e-7;  ///< seconds
  static constexpr double per_octave = 16;

  std::array<std::uint64_t, 640> bins_{};  // up to 1e5 s
  std::uint64_t steps_ = 0, slowest_ = 0;
  double longest_ = 0;
};

}  // namespace detail
}  // namespace talus
