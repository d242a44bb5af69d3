#pragma once
// The definitions of region_map.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/detail/region_map.hpp"

namespace talus::detail {

TALUS_INLINE territory::territory(any_geometry g, std::span<const territory> taken)
    : territory(std::move(g)) {
  bool changed = false;
  // The later ones may contain the earlier ones, which then need not be taken as well.
  for (auto at = taken.rbegin(); at != taken.rend(); ++at) {
    if (!overlap(pieces, at->pieces)) continue;
    pieces = without(std::move(pieces), at->pieces);
    region = any_geometry(intersect(region, complement(at->region)));
    changed = true;
  }
  if (changed) simplify();
}

TALUS_INLINE void territory::simplify() {
  if (pieces.size() != 1) return;
  drop_redundant(pieces.front());
  region = any_geometry::cell(pieces.front());
}

TALUS_INLINE region_map::region_map(std::vector<territory> regions,
                                    std::span<const any_geometry> closed) {
  for (const any_geometry& face : closed) {
    if (!face.convex())
      fail<std::invalid_argument>(
          "faces are closed in convex regions, but this one is not: {}; give its parts one by "
          "one, as in closed(left, right)",
          to_string(face));
    closed_.emplace_back(face.planes());
  }
  for (territory& own : regions) {
    const auto [lower, upper] = bounds_of(own.pieces);
    ranks_.push_back({std::move(own), lower, upper});
  }
}

TALUS_INLINE int region_map::first_empty() const {
  const auto found = std::find_if(ranks_.begin(), ranks_.end(),
                                  [](const entry& e) { return e.own.pieces.empty(); });
  return found == ranks_.end() ? -1 : static_cast<int>(found - ranks_.begin());
}

TALUS_INLINE bool region_map::meet(int a, int b, real reach) const {
  const entry& one = at(std::min(a, b));
  const entry& two = at(std::max(a, b));
  for (int axis = 0; axis < 3; ++axis)
    if (one.lower[axis] - two.upper[axis] > reach || two.lower[axis] - one.upper[axis] > reach)
      return false;
  for (const convex_piece& p : one.own.pieces)
    for (const convex_piece& q : two.own.pieces)
      if (come_within(p, q, reach)) return true;
  return false;
}

TALUS_INLINE bool region_map::meet_on_closed_faces(int a, int b) const {
  if (closed_.empty() || !meet(a, b, 0)) return false;
  const entry& one = at(std::min(a, b));
  const entry& two = at(std::max(a, b));
  for (const convex_piece& p : one.own.pieces)
    for (const convex_piece& q : two.own.pieces)
      if (come_within(p, q, 0) &&
          std::none_of(closed_.begin(), closed_.end(),
                       [&](const convex_piece& face) { return touch_only_in(p, q, face); }))
        return false;
  return true;
}

TALUS_INLINE const region_map::entry& region_map::at(int rank) const {
  if (rank < 0 || rank >= size())
    fail<std::invalid_argument>("there is no rank {} in a decomposition of {} ranks", rank, size());
  return ranks_[static_cast<std::size_t>(rank)];
}

}  // namespace talus::detail
