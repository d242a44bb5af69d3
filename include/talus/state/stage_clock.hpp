#pragma once
// Wall-clock time of one stage of a step, added up over the steps.
#include <type_traits>

#include "talus/core/clock.hpp"

namespace talus::detail {

/// Wall time, and the processor's time of this thread beside it.
struct both_times {
  double wall = 0, processor = 0;
  operator double() const { return wall; }  // NOLINT: a time as the others, with more to it
};

/// `Total` is a number, or both_times if the processor's time counts too.
template <class Total>
class stage_clock {
  static constexpr bool both = std::is_same_v<Total, both_times>;

 public:
  explicit stage_clock(Total& total) : total_(total) {}
  stage_clock(const stage_clock&) = delete;
  stage_clock& operator=(const stage_clock&) = delete;
  ~stage_clock() {
    if constexpr (both) {
      total_.wall += wall_seconds() - start_.wall;
      total_.processor += thread_seconds() - start_.processor;
    } else {
      total_ += wall_seconds() - start_;
    }
  }

 private:
  [[nodiscard]] static Total now() {
    if constexpr (both)
      return {wall_seconds(), thread_seconds()};
    else
      return wall_seconds();
  }

  Total& total_;
  Total start_ = now();
};

/// Runs a stage and adds its wall time to `total`, without that of exchanges and of functions with
/// a time of their own (function_times.hpp).
template <class State, class Stage>
void timed(State& s, double& total, Stage&& stage) {
  const double before = s.seconds.exchange + s.functions.sum();
  {
    const stage_clock clock(total);
    stage();
  }
  total -= s.seconds.exchange + s.functions.sum() - before;
}

}  // namespace talus::detail
