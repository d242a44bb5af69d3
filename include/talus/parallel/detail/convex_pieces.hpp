#pragma once
// Computations with the planes of regions: convex pieces, their contact, extent and distance. For
// the set-up, and for the rare body next to a closed face.
#include <limits>
#include <span>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/geometry/any_geometry.hpp"
#include "talus/parallel/detail/linear_program.hpp"
#include "talus/parallel/detail/plain_vectors.hpp"

namespace talus::detail {

/// The intersection of half-spaces; all of space if there are none.
using convex_piece = plain_vector<half_space>;

/// Planes as bounds of a linear program: shifted and scaled so that numbers are of order 1.
class scaled_planes {
 public:
  /// Distances below this, in the unit of length of the planes, are round-off.
  static constexpr real tiny = 1e-9;

  explicit scaled_planes(std::span<const half_space> planes, real least_unit = 0);

  [[nodiscard]] real unit() const { return unit_; }
  [[nodiscard]] vec3 point(const lp_vector& x) const {
    return plus(origin_, unit_, {x[0], x[1], x[2]});
  }
  /// n·x - depth * t >= d - slack, scaled.
  [[nodiscard]] lp_bound bound(const half_space& h, real depth = 0, real slack = 0) const;
  [[nodiscard]] plain_vector<lp_bound> bounds(real depth = 0, real slack = 0) const;

 private:
  std::span<const half_space> planes_;
  vec3 origin_;
  real unit_;
};

/// A point of maximal depth inside all half-spaces, up to the size of the whole; the depth (a
/// length) is negative if they have no common point.
struct depth_and_point {
  real depth;
  vec3 point;
};
depth_and_point deepest_point(std::span<const half_space> planes, real least_unit = 0);

/// Whether the intersection has a volume.
bool has_interior(std::span<const half_space> planes);

convex_piece joined(const convex_piece& a, const convex_piece& b);

/// Whether two pieces come within `reach` (a length) of each other. Each is widened by half of
/// that, which widens corners by more, so the result can be true for pieces slightly further apart,
/// but never false for closer ones.
bool come_within(const convex_piece& a, const convex_piece& b, real reach);

/// Whether two pieces that touch do so inside of the half-spaces of `face` only.
bool touch_only_in(const convex_piece& a, const convex_piece& b, const convex_piece& face);

/// Drops redundant planes.
void drop_redundant(convex_piece& piece);

[[nodiscard]] bool overlap(std::span<const convex_piece> some,
                           std::span<const convex_piece> others);

/// The pieces without `taken`, in pieces that do not overlap if they did not before.
std::vector<convex_piece> without(std::vector<convex_piece> pieces,
                                  std::span<const convex_piece> taken);

/// Takes a region part by part and multiplies it out into convex pieces with a volume.
class piece_collector {
 public:
  piece_collector() { open(true); }
  void open(bool all_of);
  void plane(const half_space& h) { fold({{h}}); }
  void close();
  [[nodiscard]] std::vector<convex_piece> take() { return std::move(levels_.front().pieces); }

 private:
  struct level {
    bool all_of;
    std::vector<convex_piece> pieces;
  };
  void fold(const std::vector<convex_piece>& more);

  static constexpr std::size_t most_ = 4096;
  std::vector<level> levels_;
};

/// Convex pieces with a volume that together make up a region and do not overlap.
template <concepts::polyhedral Region>
std::vector<convex_piece> pieces_of(const Region& region) {
  piece_collector collector;
  region.describe(collector);
  return collector.take();
}

/// An axis-aligned box around the pieces (lower, upper corner), slightly larger than needed, and
/// infinite on sides without bounds.
std::pair<vec3, vec3> bounds_of(std::span<const convex_piece> pieces);

/// The point of a convex piece that is nearest to p: found as the projection of p onto a plane, an
/// edge or a corner, whichever lies in the piece.
vec3 nearest_point(const convex_piece& piece, const vec3& p);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/convex_pieces_definitions.hpp"
#endif
