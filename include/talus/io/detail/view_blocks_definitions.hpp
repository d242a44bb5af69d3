#pragma once
// The definitions of view_blocks.hpp, in the compiled part or in each program.
#include <limits>

#include "talus/core/linkage.hpp"
#include "talus/io/detail/view_blocks.hpp"

namespace talus::detail {

TALUS_INLINE std::string view_json::number(double value) {
  return std::isfinite(value) ? text(value) : "null";
}
TALUS_INLINE std::string view_json::vector(const vec3& v) {
  return "[" + number(v[0]) + "," + number(v[1]) + "," + number(v[2]) + "]";
}
TALUS_INLINE void view_json::add_raw(std::string_view key, std::string_view json) {
  if (!text_.empty()) text_ += ',';
  ((text_ += detail::quoted_text(key)) += ':') += json;
}
TALUS_INLINE void view_json::add(std::string_view key, double value) {
  add_raw(key, number(value));
}
TALUS_INLINE void view_json::add_text(std::string_view key, std::string_view text) {
  add_raw(key, detail::quoted_text(text));
}

TALUS_INLINE view_grid::view_grid(const plain_vector<view_body>& all) {
  constexpr double most = std::numeric_limits<double>::max();
  vec3 upper{-most, -most, -most};
  lower_ = {most, most, most};
  double smallest = most, largest = 0;
  for (const view_body& b : all) {
    for (int k = 0; k < 3; ++k) {
      lower_[k] = std::min(lower_[k], b.position[k]), upper[k] = std::max(upper[k], b.position[k]);
      largest = std::max(largest, std::abs(b.position[k]));
    }
    if (b.shape == view_shape::plane) continue;
    smallest = std::min<double>(smallest, std::max({b.size[0], b.size[1], b.size[2]}) / 2);
  }
  if (all.empty()) lower_ = upper = {0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    const double extent = upper[k] - lower_[k];
    cell_[k] = extent > 0 ? extent / 65535 : 1;
    if (extent > 0) error_ = std::max(error_, cell_[k] / 2);
  }
  whole_ = error_ <= 0.002 * smallest;
  if (whole_) return;
  lower_ = {0, 0, 0}, cell_ = {1, 1, 1};
  error_ = std::ldexp(largest, -24);
}

}  // namespace talus::detail
