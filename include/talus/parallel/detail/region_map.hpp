#pragma once
// Regions of any form, one for each rank, and their contacts and faces.
#include "talus/parallel/detail/convex_pieces.hpp"

namespace talus::detail {

/// A region, and the same in convex pieces.
struct territory {
  any_geometry region;
  std::vector<convex_piece> pieces;

  explicit territory(any_geometry g) : region(std::move(g)), pieces(pieces_of(region)) {}
  /// The region without those of others. Regions that do not overlap it leave it unchanged, to the
  /// bit.
  territory(any_geometry g, std::span<const territory> taken) : territory(std::move(g)) {
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
  /// A single convex piece has a simpler form with its own faces only.
  void simplify() {
    if (pieces.size() != 1) return;
    drop_redundant(pieces.front());
    region = any_geometry::cell(pieces.front());
  }
};

class region_map {
 public:
  region_map() = default;
  /// The region of each rank, and convex regions in which no body ever crosses a face.
  region_map(std::vector<territory> regions, std::span<const any_geometry> closed) {
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

  [[nodiscard]] int size() const { return static_cast<int>(ranks_.size()); }
  [[nodiscard]] const any_geometry& geometry(int rank) const { return at(rank).own.region; }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const {
    return {at(rank).lower, at(rank).upper};
  }
  /// The first rank without space; -1 if all have some.
  [[nodiscard]] int first_empty() const {
    const auto found = std::find_if(ranks_.begin(), ranks_.end(),
                                    [](const entry& e) { return e.own.pieces.empty(); });
    return found == ranks_.end() ? -1 : static_cast<int>(found - ranks_.begin());
  }

  /// Whether two regions come within `reach` of each other. The same from both sides.
  [[nodiscard]] bool meet(int a, int b, real reach) const {
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
  /// Whether two regions touch, and on closed faces only.
  [[nodiscard]] bool meet_on_closed_faces(int a, int b) const {
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

 private:
  struct entry {
    territory own;
    vec3 lower, upper;
  };
  [[nodiscard]] const entry& at(int rank) const {
    if (rank < 0 || rank >= size())
      fail<std::invalid_argument>("there is no rank {} in a decomposition of {} ranks", rank,
                                  size());
    return ranks_[static_cast<std::size_t>(rank)];
  }

  std::vector<entry> ranks_;
  std::vector<convex_piece> closed_;
};

}  // namespace talus::detail
