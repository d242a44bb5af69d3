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
  territory(any_geometry g, std::span<const territory> taken);
  /// A single convex piece has a simpler form with its own faces only.
  void simplify();
};

class region_map {
 public:
  region_map() = default;
  /// The region of each rank, and convex regions in which no body ever crosses a face.
  region_map(std::vector<territory> regions, std::span<const any_geometry> closed);

  [[nodiscard]] int size() const { return static_cast<int>(ranks_.size()); }
  [[nodiscard]] const any_geometry& geometry(int rank) const { return at(rank).own.region; }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const {
    return {at(rank).lower, at(rank).upper};
  }
  /// The first rank without space; -1 if all have some.
  [[nodiscard]] int first_empty() const;

  /// Whether two regions come within `reach` of each other. The same from both sides.
  [[nodiscard]] bool meet(int a, int b, real reach) const;
  /// Whether two regions touch, and on closed faces only.
  [[nodiscard]] bool meet_on_closed_faces(int a, int b) const;

 private:
  struct entry {
    territory own;
    vec3 lower, upper;
  };
  [[nodiscard]] const entry& at(int rank) const;

  std::vector<entry> ranks_;
  std::vector<convex_piece> closed_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/region_map_definitions.hpp"
#endif
