#pragma once
// The definitions of sweep_and_prune.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/detect/sweep_and_prune.hpp"

namespace talus {

TALUS_INLINE void sorted_balls::build(std::span<const vec3> centres,
                                      std::span<const real> reaches) {
  if (centres.size() != reaches.size() || centres.size() >= std::uint32_t(-1) / 8)
    detail::fail<std::invalid_argument>(
        "sorted_balls::build was given {} centres and {} reaches; give one reach per centre, "
        "below 2^29",
        centres.size(), reaches.size());
  detail::require_placeable(centres, reaches);
  balls_.clear();
  axis_ = 0, widest_ = 0;
  if (centres.empty()) return;

  vec3 mean{0, 0, 0}, spread{0, 0, 0};
  for (const vec3& c : centres) mean += c / static_cast<real>(centres.size());
  for (const vec3& c : centres) spread += (c - mean).cwiseProduct(c - mean);
  spread.maxCoeff(&axis_);

  balls_.reserve(centres.size());
  for (std::uint32_t i = 0; i < centres.size(); ++i)
    balls_.push_back(along_axis(centres[i], reaches[i], i));
  std::sort(balls_.begin(), balls_.end(), [](const ball& a, const ball& b) {
    return a.low != b.low ? a.low < b.low : a.index < b.index;
  });
  for (const ball& b : balls_) widest_ = std::max(widest_, b.high - b.low);
}

}  // namespace talus
