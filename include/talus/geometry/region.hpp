#pragma once
// What a part of space must offer, and what it may be made of.
#include <concepts>

#include "talus/core/math.hpp"

namespace talus {

/// A part of space, as a value. `value(p)` is positive strictly inside, zero on the boundary and
/// negative outside, and its magnitude never exceeds the distance from `p` to the boundary (up to
/// round-off): `-value(p)` is a lower bound of the distance from `p` to the region. `contains(p)`
/// is `value(p) >= 0`: regions are closed.
template <class Region>
concept region = requires(const Region& r, const vec3& p) {
  { r.value(p) } -> std::convertible_to<real>;
  { r.contains(p) } -> std::same_as<bool>;
};

namespace detail {

/// Receives a geometry part by part: groups open and close, half-spaces lie between.
struct any_description_sink {
  void open(bool all_of);
  template <class HalfSpace>
  void plane(const HalfSpace&);
  void close();
};

}  // namespace detail

/// A region bounded by planes. `owns(p)` is `contains(p)` but for the boundary, which it gives to
/// exactly one of a region and its complement: the side that lies towards +x, where that does not
/// tell towards +y, then +z. Regions that tile space thus share out every point exactly once.
template <class Region>
concept polyhedral = region<Region> &&
    requires(const Region& r, const vec3& p, detail::any_description_sink& sink) {
  { r.owns(p) } -> std::same_as<bool>;
  r.describe(sink);
};

}  // namespace talus
