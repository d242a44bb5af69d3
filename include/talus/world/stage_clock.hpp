#pragma once
// Wall-clock time of one stage of a step, added up over the steps.
#include "talus/core/clock.hpp"

namespace talus::detail {

class stage_clock {
 public:
  explicit stage_clock(double& total) : total_(total) {}
  stage_clock(const stage_clock&) = delete;
  stage_clock& operator=(const stage_clock&) = delete;
  ~stage_clock() { total_ += wall_seconds() - start_; }

 private:
  double& total_;
  double start_ = wall_seconds();
};

}  // namespace talus::detail
