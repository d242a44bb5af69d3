#pragma once
// The pieces of a frame of the viewer's page: its head as JSON, its arrays, its grid of positions.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/io/detail/view_part.hpp"

namespace talus::detail {

/// A growing JSON object. Numbers that are not finite become null.
class view_json {
 public:
  [[gnu::cold]] void add(std::string_view key, double value);
  [[gnu::cold]] void add_text(std::string_view key, std::string_view text);
  /// A value that is JSON already.
  [[gnu::cold]] void add_raw(std::string_view key, std::string_view json);
  [[nodiscard]] std::string str() const { return "{" + text_ + "}"; }
  [[nodiscard, gnu::cold]] static std::string number(double value);
  /// A list of three numbers.
  [[nodiscard, gnu::cold]] static std::string vector(const vec3& v);

 private:
  std::string text_;
};

/// The arrays of a frame, each at a multiple of eight bytes, and where they are.
class view_blocks {
 public:
  explicit view_blocks(byte_buffer& to) : to_(to) {}
  template <class T>
  void put(std::string_view name, const plain_vector<T>& values) {
    put(name, std::span(values.data(), values.size()));
  }
  template <class T>
  void put(std::string_view name, std::span<const T> values) {
    static_assert(std::is_arithmetic_v<T>);
    to_.resize((to_.size() + 7) / 8 * 8);
    const std::size_t at = to_.size();
    to_.resize(at + values.size_bytes());
    if (!values.empty()) std::memcpy(to_.data() + at, values.data(), values.size_bytes());
    constexpr char kind = std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
    where_.add_raw(name, compose("[\"{}{}\",{},{}]", kind, 8 * sizeof(T), at, values.size()));
  }
  [[nodiscard]] std::string where() const { return where_.str(); }

 private:
  byte_buffer& to_;
  view_json where_;
};

/// Converts sizes to whole numbers of cells in [0, 65535].
[[nodiscard]] inline std::uint16_t cells_of(double x) {
  return static_cast<std::uint16_t>(std::clamp(std::round(x), 0.0, 65535.0));
}

/// The grid of whole cells in which a frame holds its positions. Where cells would be coarse beside
/// bodies it has numbers of single precision instead.
class view_grid {
 public:
  [[gnu::cold]] explicit view_grid(const plain_vector<view_body>& all);
  /// `each(f)` calls f(point) for all points.
  template <class Each>
  void put(std::string_view name, view_blocks& to, Each&& each) const;

  [[nodiscard]] double error() const { return error_; }
  [[nodiscard]] const vec3& lower() const { return lower_; }
  [[nodiscard]] const vec3& cell() const { return cell_; }
  [[nodiscard]] bool whole() const { return whole_; }

 private:
  vec3 lower_{0, 0, 0}, cell_{1, 1, 1};
  double error_ = 0;
  bool whole_ = true;
};

template <class Each>
void view_grid::put(std::string_view name, view_blocks& to, Each&& each) const {
  plain_vector<std::uint16_t> cells;
  plain_vector<float> numbers;
  each([&](const vec3& p) {
    for (int k = 0; k < 3; ++k)
      if (whole_)
        cells.push_back(cells_of((p[k] - lower_[k]) / cell_[k]));
      else
        numbers.push_back(static_cast<float>(p[k]));
  });
  if (whole_)
    to.put(name, cells);
  else
    to.put(name, numbers);
}

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/detail/view_blocks_definitions.hpp"
#endif
