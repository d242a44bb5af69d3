#pragma once
// The definitions of closed_neighbour.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/closed_neighbour.hpp"

namespace talus {

TALUS_INLINE std::optional<closed_neighbour::place> closed_neighbour::within(const vec3& p,
                                                                             real radius) const {
  std::optional<place> best;
  if (-region_.value(p) > radius) return best;
  for (const detail::convex_piece& piece : pieces_) {
    const vec3 q = detail::nearest_point(piece, p);
    const real distance = (q - p).norm();
    if (distance > radius || (best && distance >= best->distance)) continue;
    const auto face = std::min_element(
        piece.begin(), piece.end(),
        [&](const half_space& a, const half_space& b) { return a.value(p) < b.value(p); });
    if (face != piece.end()) best = place{q, distance, *face};
  }
  return best;
}

}  // namespace talus
