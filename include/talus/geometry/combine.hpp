#pragma once
// Regions made of regions, as types: intersect, merge and complement, nested at will.
#include <limits>
#include <tuple>

#include "talus/geometry/half_space.hpp"

namespace talus {

namespace detail {

/// The points in all of (All) or in any of the parts; made by intersect and merge. The value is
/// the smallest or the largest of the values of the parts.
template <bool All, class... Parts>
class combination {
 public:
  constexpr explicit combination(Parts... parts) : parts_(std::move(parts)...) {}

  [[nodiscard]] real value(const vec3& p) const {
    constexpr real none = std::numeric_limits<real>::infinity();
    real result = All ? none : -none;
    const auto fold = [&](real v) {
      result = (All ? result < v : result > v) ? result : v;
    };  // NaN stays
    std::apply([&](const auto&... part) { (fold(part.value(p)), ...); }, parts_);
    return result;
  }
  [[nodiscard]] bool contains(const vec3& p) const { return value(p) >= 0; }
  [[nodiscard]] bool owns(const vec3& p) const {
    return std::apply(
        [&](const auto&... part) {
          if constexpr (All)
            return (part.owns(p) && ...);
          else
            return (part.owns(p) || ...);
        },
        parts_);
  }
  [[nodiscard]] constexpr const std::tuple<Parts...>& parts() const { return parts_; }

  friend constexpr bool operator==(const combination&, const combination&) = default;

  template <class Sink>
  void describe(Sink& sink) const {
    sink.open(All);
    std::apply([&](const auto&... part) { (part.describe(sink), ...); }, parts_);
    sink.close();
  }

 private:
  std::tuple<Parts...> parts_;
};

}  // namespace detail

/// The points that lie in all of the regions.
template <concepts::polyhedral... Regions>
[[nodiscard]] constexpr auto intersect(Regions... regions) {
  return detail::combination<true, Regions...>(std::move(regions)...);
}

/// The points that lie in at least one of the regions.
template <concepts::polyhedral... Regions>
[[nodiscard]] constexpr auto merge(Regions... regions) {
  return detail::combination<false, Regions...>(std::move(regions)...);
}

/// The other side of a plane.
[[nodiscard]] constexpr half_space complement(const half_space& h) { return h.flipped(); }

/// The complement of a combination, by De Morgan: its value is exactly the negative.
template <bool All, class... Parts>
[[nodiscard]] constexpr auto complement(const detail::combination<All, Parts...>& c) {
  return std::apply(
      [](const auto&... part) {
        return detail::combination<!All, decltype(complement(part))...>(complement(part)...);
      },
      c.parts());
}

}  // namespace talus
