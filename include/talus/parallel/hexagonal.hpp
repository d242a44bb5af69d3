#pragma once
// Hexagonal prisms in rings around a centre: round domains with at most six neighbours.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "talus/core/field_names.hpp"
#include "talus/parallel/detail/convex_pieces.hpp"
#include "talus/parallel/detail/directions.hpp"
#include "talus/parallel/dynamic.hpp"

namespace talus {

/// Each point belongs to the nearest cell centre, of several to that of the lowest rank. So the
/// cells at the border extend to infinity. No data are stored per cell.
class hexagonal_cells {
 public:
  /// A cell by its steps from the centre along `start` and along the direction 60 degrees from it.
  struct place {
    int q, r;
    friend bool operator==(const place&, const place&) = default;
  };

  hexagonal_cells(int rings, real spacing, const detail::axis_frame& frame, const vec3& centre)
      : rings_(rings), spacing_(spacing), frame_(frame), centre_(centre) {
    for (std::size_t i = 0; i < 3; ++i) normals_[i] = offset(steps_[i]);
  }

  [[nodiscard]] static int size_of(int rings) { return 3 * rings * (rings + 1) + 1; }
  [[nodiscard]] int size() const { return size_of(rings_); }
  [[nodiscard]] int rings() const { return rings_; }
  /// The centre of a cell.
  [[nodiscard]] vec3 centre(int rank) const {
    return detail::plus(centre_, spacing_, offset(place_of(rank)));
  }

  [[nodiscard]] int owner(const vec3& point) const;

  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const;
  [[nodiscard]] any_geometry geometry(int rank) const { return any_geometry::cell(planes(rank)); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const;

  /// Ranks are numbered outwards ring by ring, in each ring from `start` on towards the second
  /// direction.
  [[nodiscard]] place place_of(int rank) const;
  [[nodiscard]] static int rank_of(const place& at);

 private:
  static constexpr real height_ = 0.8660254037844386;  // of a triangle, sqrt(3)/2
  static constexpr std::array<place, 6> steps_{
      {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}}};

  /// From the central cell, in units of the spacing.
  [[nodiscard]] vec3 offset(const place& at) const {
    return frame_.towards(at.q + at.r / real(2), at.r * height_);
  }
  /// Number of steps from the centre.
  [[nodiscard]] static int distance(const place& at) {
    return std::max({std::abs(at.q), std::abs(at.r), std::abs(at.q + at.r)});
  }
  /// A cell near the point: the one in which it lies, except for round-off and points outside.
  [[nodiscard]] place guess(real u, real w) const;
  /// One plane for each pair of neighbours, computed identically by both.
  [[nodiscard]] detail::convex_piece planes(int rank) const;

  int rings_;
  real spacing_;
  detail::axis_frame frame_;
  vec3 centre_;
  std::array<vec3, 3> normals_;  // of the faces in the first three directions
};

/// Hexagonal prisms in Rings rings around a central one: 1, 7, 19, 37, 61, 91, ... ranks, each with
/// at most six neighbours. The cells at the border extend to infinity.
///   hexagonal<5>{.spacing = 10}            91 ranks
///   hexagonal<dynamic>{.width = 60}        rings as many as the ranks make
template <int Rings>
struct hexagonal {
  using talus_fields = detail::fields::hexagonal_fields;
  static_assert(Rings >= 0 || Rings == dynamic,
                "hexagonal<R> takes the number of rings around the central cell, 0 or more, or "
                "hexagonal<dynamic>");
  static constexpr real unset = std::numeric_limits<real>::quiet_NaN();

  int rings =
      dynamic;  ///< Rings of hexagonal<dynamic>; dynamic: as follows from the number of ranks.
  /// Distance of the centres of neighbouring cells, which is the width of a cell from flat to flat
  /// (length). From corner to corner a cell measures 2 / sqrt(3) of it.
  real spacing = unset;
  /// Instead of it, the width of all cells together along `start`, from flat to flat (length): that
  /// of 2 rings + 1 cells.
  real width = unset;
  vec3 centre{0, 0, 0};  ///< Centre of the central cell (length).
  vec3 axis{0, 0, 1};    ///< Axis of the prisms; any length but zero.
  vec3 start{1, 0, 0};   ///< Direction from rank 0 to rank 1, made perpendicular to the axis.

  /// The number of ranks, 0 while it is open.
  [[nodiscard]] int size() const {
    const int n = chosen();
    return n == dynamic ? 0 : hexagonal_cells::size_of(n);
  }

  [[nodiscard]] hexagonal_cells resolve(int ranks) const {
    int n = chosen();
    if (n == dynamic)
      for (n = 0; hexagonal_cells::size_of(n) < ranks;) ++n;
    if (hexagonal_cells::size_of(n) != ranks && chosen() == dynamic)
      detail::fail<std::invalid_argument>(
          "hexagonal cells in whole rings are 1, 7, 19, 37, 61, 91, ..., one for each rank, but "
          "there are {} ranks: start the program with {} or {}",
          ranks, hexagonal_cells::size_of(n - 1), hexagonal_cells::size_of(n));
    if (hexagonal_cells::size_of(n) != ranks)
      detail::fail<std::invalid_argument>(
          "{} hexagonal cell(s) in {} ring(s) around one need exactly {} ranks, but there are {}: "
          "start the program with {}{}",
          hexagonal_cells::size_of(n) - 1, n, hexagonal_cells::size_of(n), ranks,
          hexagonal_cells::size_of(n),
          Rings == dynamic ? ", or leave .rings out, so that they follow from the ranks"
                           : ", or use hexagonal<dynamic>, which fits 1, 7, 19, 37, 61, 91, ...");
    const bool by_width = width == width;
    if (by_width && spacing == spacing)
      detail::fail<std::invalid_argument>(
          "hexagonal has both a .spacing of {} and a .width of {}: give one of the two", spacing,
          width);
    if (by_width) detail::require_positive(width, "the .width of all cells of hexagonal");
    const real distance = by_width ? width / (2 * n + 1) : spacing;
    if (ranks > 1 || distance == distance)
      detail::require_positive(distance, "the .spacing of the cells of hexagonal");
    if (!detail::finite(centre))
      detail::fail<std::invalid_argument>("the .centre of hexagonal must be finite, but is {}",
                                          detail::text(centre));
    return {n, ranks > 1 ? distance : 1, detail::axis_frame("hexagonal", axis, start), centre};
  }

 private:
  [[nodiscard]] int chosen() const {
    return detail::chosen_size("hexagonal", "rings", Rings, rings, dynamic, 0);
  }
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/hexagonal_definitions.hpp"
#endif
