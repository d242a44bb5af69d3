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

  [[nodiscard]] part_of_space below(const bisection_cut& c) const {
    part_of_space result = *this;
    result.upper[static_cast<std::size_t>(c.axis)] = c.at;
    return result;
  }
  [[nodiscard]] part_of_space above(const bisection_cut& c) const {
    part_of_space result = *this;
    result.lower[static_cast<std::size_t>(c.axis)] = c.at;
    return result;
  }
  /// Whether a cut leaves space on both of its sides.
  [[nodiscard]] bool divided_by(const bisection_cut& c) const {
    const auto k = static_cast<std::size_t>(c.axis);
    return std::isfinite(c.at) && lower[k] < c.at && c.at < upper[k];
  }
  /// Whether two boxes are at most `reach` apart along each axis.
  [[nodiscard]] bool near(const part_of_space& other, real reach) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (lower[k] - other.upper[k] > reach || other.lower[k] - upper[k] > reach) return false;
    return true;
  }
};

}  // namespace detail

/// The domains of recursive bisection. A part for n ranks has a cut; n/2 of them, rounded down, are
/// below it, the others above. A point on a cut is above it. So the owner of a point depends on the
/// cuts alone, and both sides of a cut have the same number.
class bisection_cells {
 public:
  /// The first cut, then those of the part below it, then those of the part above. Throws
  /// invalid_argument for a cut outside the part that it divides.
  bisection_cells(std::vector<bisection_cut> cuts, int ranks) : cuts_(std::move(cuts)), n_(ranks) {
    for (bisection_cut& c : cuts_) {
      c.at += 0.0;  // -0 becomes 0
      if (c.axis < 0 || c.axis > 2)
        detail::fail<std::invalid_argument>(
            "a cut of a bisection is across axis {}, but axes are 0, 1 and 2 for x, y and z",
            c.axis);
    }
    require({}, 0, n_);
  }

  [[nodiscard]] int size() const { return n_; }
  [[nodiscard]] const std::vector<bisection_cut>& cuts() const { return cuts_; }

  [[nodiscard]] int owner(const vec3& p) const {
    if (detail::has_nan(p)) return -1;
    int first = 0, n = n_;
    for (std::size_t cut = 0; n > 1;) {
      const int below = detail::ranks_below(n);
      if (p[cuts_[cut].axis] < cuts_[cut].at) {
        n = below, cut += 1;
      } else {
        first += below, n -= below, cut += static_cast<std::size_t>(below);
      }
    }
    return first;
  }

  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const {
    std::vector<int> ranks;
    collect(box(rank), reach, {}, 0, 0, n_, ranks);
    std::erase(ranks, rank);
    return ranks;
  }

  [[nodiscard]] any_geometry geometry(int rank) const {
    const detail::part_of_space own = box(rank);
    detail::plain_vector<half_space> planes;
    for (int axis = 0; axis < 3; ++axis) {
      const vec3 normal = vec3::Unit(axis);
      const auto k = static_cast<std::size_t>(axis);
      if (std::isfinite(own.lower[k])) planes.push_back({normal, own.lower[k]});
      if (std::isfinite(own.upper[k])) planes.push_back(half_space(normal, own.upper[k]).flipped());
    }
    return any_geometry::cell(planes);
  }

  [[nodiscard]] grid_cells::cell_bounds cell(int rank) const {
    const detail::part_of_space own = box(rank);
    return {own.lower, own.upper};
  }

 private:
  [[nodiscard]] detail::part_of_space box(int rank) const {
    if (rank < 0 || rank >= n_)
      detail::fail<std::invalid_argument>("there is no rank {} in a bisection for {} ranks", rank,
                                          n_);
    detail::part_of_space part;
    int n = n_;
    for (std::size_t cut = 0; n > 1;) {
      const int below = detail::ranks_below(n);
      if (rank < below) {
        part = part.below(cuts_[cut]);
        n = below, cut += 1;
      } else {
        part = part.above(cuts_[cut]);
        rank -= below, n -= below, cut += static_cast<std::size_t>(below);
      }
    }
    return part;
  }
  /// The part of `n` ranks from `first` on is divided by `cut`.
  void collect(const detail::part_of_space& own, real reach, const detail::part_of_space& part,
               std::size_t cut, int first, int n, std::vector<int>& ranks) const {
    if (!own.near(part, reach)) return;
    if (n == 1) return ranks.push_back(first);
    const int below = detail::ranks_below(n);
    collect(own, reach, part.below(cuts_[cut]), cut + 1, first, below, ranks);
    collect(own, reach, part.above(cuts_[cut]), cut + static_cast<std::size_t>(below),
            first + below, n - below, ranks);
  }
  [[gnu::cold]] void require(const detail::part_of_space& part, std::size_t cut, int n) const {
    if (n == 1) return;
    const bisection_cut& c = cuts_.at(cut);
    const auto k = static_cast<std::size_t>(c.axis);
    if (!part.divided_by(c))
      detail::fail<std::invalid_argument>(
          "cut {} of a bisection, at {} across {}, does not divide the part of space that it is "
          "for, which goes from {} to {} there; the first cut comes first, then those below it, "
          "then those above",
          cut, c.at, "xyz"[k], part.lower[k], part.upper[k]);
    const int below = detail::ranks_below(n);
    require(part.below(c), cut + 1, below);
    require(part.above(c), cut + static_cast<std::size_t>(below), n - below);
  }

  std::vector<bisection_cut> cuts_;
  int n_;
};

}  // namespace talus
