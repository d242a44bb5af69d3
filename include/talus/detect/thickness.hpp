#pragma once
// How thick a body is where it is thinnest.
#include <algorithm>
#include <limits>

#include "talus/core/math.hpp"
#include "talus/detect/detail/convex_view.hpp"

namespace talus::detail {

/// Half the thickness of a body where it is thinnest, a length: what depths are measured by. A
/// union has that of its thinnest part; what is infinite is so in depth, too.
template <class Shape>
[[nodiscard]] real half_thickness(const Shape& s) {
  if constexpr (requires { convex_view<real>(s, pose{}); }) {
    return convex_view<real>(s, pose{}).smallest();
  } else if constexpr (requires { s.each_part([](const auto&, const pose&) {}); }) {
    real least = s.bounding_radius();
    s.each_part(
        [&](const auto& part, const pose&) { least = std::min(least, half_thickness(part)); });
    return least;
  } else if constexpr (Shape::finite) {
    return s.bounding_radius();
  } else {
    return std::numeric_limits<real>::infinity();
  }
}

}  // namespace talus::detail
