#pragma once
// The boxes of recursive bisection with known cuts.
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/geometry/any_geometry.hpp"
#include "talus/parallel/grid.hpp"

namespace talus {

/// A plane across an axis (0, 1, 2: x, y, z) that divides a part of space in two.
struct bisection_cut {
  int axis = 0;
  real at = 0;  ///< Position along the axis (length).

  friend bool operator==(const bisection_cut&, const bisection_cut&) = default;
};

namespace detail {

/// The number of ranks below the cut of a part with n ranks.
[[nodiscard]] inline int ranks_below(int n) { return n / 2; }

/// A box of space; infinite on sides without bounds.
struct part_of_space {
  static constexpr real infinity = std::numeric_limits<real>::infinity();
  std::array<real, 3> lower{-infinity, -infinity, -infinity}, upper{infinity, infinity, infinity};

  [[nodiscard]] part_of_space below(const bisection_cut& c) const;
  [[nodiscard]] part_of_space above(const bisection_cut& c) const;
  /// Whether a cut leaves space on both of its sides.
  [[nodiscard]] bool divided_by(const bisection_cut& c) const;
  /// Whether two boxes are at most `reach` apart along each axis.
  [[nodiscard]] bool near(const part_of_space& other, real reach) const;
};

}  // namespace detail

/// The domains of recursive bisection. A part for n ranks has a cut; n/2 of them, rounded down, are
/// below it, the others above. A point on a cut is above it. So the owner of a point depends on the
/// cuts alone, and both sides of a cut have the same number.
class bisection_cells {
 public:
  /// The first cut, then those of the part below it, then those of the part above. Throws
  /// invalid_argument for a cut outside the part that it divides.
  bisection_cells(std::vector<bisection_cut> cuts, int ranks);

  [[nodiscard]] int size() const { return n_; }
  [[nodiscard]] const std::vector<bisection_cut>& cuts() const { return cuts_; }

  [[nodiscard]] int owner(const vec3& p) const;

  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const;

  [[nodiscard]] any_geometry geometry(int rank) const;

  [[nodiscard]] grid_cells::cell_bounds cell(int rank) const;

 private:
  [[nodiscard]] detail::part_of_space box(int rank) const;
  /// The part of `n` ranks from `first` on is divided by `cut`.
  void collect(const detail::part_of_space& own, real reach, const detail::part_of_space& part,
               std::size_t cut, int first, int n, std::vector<int>& ranks) const;
  [[gnu::cold]] void require(const detail::part_of_space& part, std::size_t cut, int n) const;

  std::vector<bisection_cut> cuts_;
  int n_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/bisection_cells_definitions.hpp"
#endif
