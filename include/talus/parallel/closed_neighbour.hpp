#pragma once
// A rank on the other side of a closed face: near, but not connected.
#include <limits>
#include <optional>

#include "talus/parallel/detail/convex_pieces.hpp"

namespace talus {

/// A rank whose region touches that of this rank on closed faces only. Bodies must keep away from
/// there.
class closed_neighbour {
 public:
  closed_neighbour(int rank, any_geometry region)
      : rank_(rank), region_(std::move(region)), pieces_(detail::pieces_of(region_)) {}

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] const any_geometry& geometry() const { return region_; }

  /// The point of that rank's region nearest to a point, if it is not further than `radius`.
  struct place {
    vec3 nearest;     ///< The point of the region that is nearest; the point itself if inside.
    real distance;    ///< From the point; 0 inside.
    half_space face;  ///< The plane of the region that the point is furthest behind.
  };
  /// The nearest of all pieces within `radius`; cheap for distant points.
  [[nodiscard]] std::optional<place> within(const vec3& p, real radius) const;

 private:
  int rank_;
  any_geometry region_;
  std::vector<detail::convex_piece> pieces_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/closed_neighbour_definitions.hpp"
#endif
