#pragma once
// Wall-clock time of one stage of a step, added up over the steps.
#include <chrono>

namespace talus::detail {

class stage_clock {
 public:
  explicit stage_clock(double& total) : total_(total), start_(now()) {}
  stage_clock(const stage_clock&) = delete;
  stage_clock& operator=(const stage_clock&) = delete;
  ~stage_clock() { total_ += std::chrono::duration<double>(now() - start_).count(); }

 private:
  static std::chrono::steady_clock::time_point now() { return std::chrono::steady_clock::now(); }
  double& total_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace talus::detail
