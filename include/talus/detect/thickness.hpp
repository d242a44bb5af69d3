#pragma once
// The smallest thickness of a body.
#include <algorithm>
#include <limits>

#include "talus/concepts.hpp"
#include "talus/core/math.hpp"
#include "talus/detect/detail/convex_view.hpp"

namespace talus::detail {

/// Half the smallest thickness of a body (length), the scale of penetration depths. A union has
/// that of its thinnest part; it is infinite for infinite bodies.
template <class Shape>
[[nodiscard]] real half_thickness(const Shape& s) {
  if constexpr (Shape::finite && Shape::isotropic) {
    return s.bounding_radius();
  } else if constexpr (concepts::convex_shape<Shape>) {
    return convex_view<real>(form_of(s), pose{}).smallest();
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
