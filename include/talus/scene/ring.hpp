#pragma once
// Stacked rings of sites: walls of wells and towers.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "talus/core/portable_trigonometry.hpp"
#include "talus/scene/site.hpp"

namespace talus {

/// `levels` rings of `count` sites around a vertical axis. The orientation of a site turns the
/// y axis of a body outwards. Site i of level l has the index l count + i.
struct ring_of {
  int count = 1;         ///< sites of each ring; the well has 40
  int levels = 1;        ///< rings; the well has 5
  real radius = 1;       ///< of the circle of sites (length)
  real height = 1;       ///< of one level (length); sites are half way up
  vec3 centre{0, 0, 0};  ///< of the lowest ring's lower side
  real turn = 0.5;       ///< fraction of a site by which levels 0, 2, 4, ... are turned

  /// Throws invalid_argument for invalid numbers.
  void validate() const {
    if (count < 1 || levels < 0)
      detail::fail<std::invalid_argument>(
          "a ring needs at least one site and no negative number of levels, but has {} and {}",
          count, levels);
    detail::require_positive(radius, "the radius of a ring");
    detail::require_positive(height, "the height of a level of rings");
    if (!detail::finite(centre) || !std::isfinite(turn))
      detail::fail<std::invalid_argument>(
          "the centre and the turn of a ring must be finite, but are {} and {}",
          detail::text(centre), turn);
  }

  using site_type = site;

  /// One of its sites.
  [[nodiscard]] site at(int level, int i) const {
    const real angle = 2 * pi * (i + (level % 2 == 0 ? turn : 0)) / count;
    const vec3 outwards{-portable::sin(angle), portable::cos(angle), 0};
    return {centre + radius * outwards + vec3(0, 0, (level + real(0.5)) * height),
            quat(portable::cos(angle / 2), 0, 0, portable::sin(angle / 2)),
            static_cast<std::uint64_t>(level) * static_cast<std::uint64_t>(count) +
                static_cast<std::uint64_t>(i)};
  }

  template <class F>
  void for_each_in(const vec3& lower, const vec3& upper, F&& f) const {
    validate();
    const auto [from, to] = sites_seen(lower, upper);
    const auto level_of = [&](real z) {
      return static_cast<int>(std::floor(std::clamp((z - centre[2]) / height, -1.0, levels + 1.0)));
    };
    const int top = std::min(levels - 1, level_of(upper[2]) + 1);
    for (int level = std::max(0, level_of(lower[2]) - 1); level <= top; ++level)
      for (int i = from; i <= to; ++i) {
        const site s = at(level, (i % count + count) % count);
        if (detail::between(lower, s.position, upper)) f(s);
      }
  }
  /// The first n sites of the lattice.
  [[nodiscard]] auto first(std::uint64_t n) const { return first_sites<ring_of>(*this, n); }

 private:
  /// Sites whose angles about the axis the box can cover; the last may wrap around.
  [[nodiscard]] std::pair<int, int> sites_seen(const vec3& lower, const vec3& upper) const {
    const std::pair<int, int> all{0, count - 1};
    std::array<real, 2> x, y;  // of the box, cut to what the ring can reach
    for (int side = 0; side < 2; ++side) {
      const auto cut = [&](int a) {
        return std::clamp((side ? upper : lower)[a] - centre[a], -2 * radius, 2 * radius);
      };
      x[side] = cut(0);
      y[side] = cut(1);
    }
    if (x[0] > x[1] || y[0] > y[1]) return {0, -1};
    if (x[0] <= 0 && x[1] >= 0 && y[0] <= 0 && y[1] >= 0) return all;
    const real mid_x = (x[0] + x[1]) / 2, mid_y = (y[0] + y[1]) / 2;
    real least = 0, most = 0;  // angles from the direction of the middle
    for (const real px : x)
      for (const real py : y) {
        const real angle = portable::atan2(mid_x * py - mid_y * px, mid_x * px + mid_y * py);
        least = std::min(least, angle);
        most = std::max(most, angle);
      }
    const real middle = portable::atan2(-mid_x, mid_y), site_angle = 2 * pi / count;
    const real from = std::floor((middle + least) / site_angle - std::max(turn, real(0))) - 1;
    const real to = std::ceil((middle + most) / site_angle - std::min(turn, real(0))) + 1;
    if (to - from + 1 >= count) return all;
    return {static_cast<int>(from), static_cast<int>(to)};
  }
};

}  // namespace talus
