#pragma once
// The definitions of bisection_cells.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/bisection_cells.hpp"

namespace talus::detail {

TALUS_INLINE part_of_space part_of_space::below(const bisection_cut& c) const {
  part_of_space result = *this;
  result.upper[static_cast<std::size_t>(c.axis)] = c.at;
  return result;
}

TALUS_INLINE part_of_space part_of_space::above(const bisection_cut& c) const {
  part_of_space result = *this;
  result.lower[static_cast<std::size_t>(c.axis)] = c.at;
  return result;
}

TALUS_INLINE bool part_of_space::divided_by(const bisection_cut& c) const {
  const auto k = static_cast<std::size_t>(c.axis);
  return std::isfinite(c.at) && lower[k] < c.at && c.at < upper[k];
}

TALUS_INLINE bool part_of_space::near(const part_of_space& other, real reach) const {
  for (std::size_t k = 0; k < 3; ++k)
    if (lower[k] - other.upper[k] > reach || other.lower[k] - upper[k] > reach) return false;
  return true;
}

}  // namespace talus::detail

namespace talus {

TALUS_INLINE bisection_cells::bisection_cells(std::vector<bisection_cut> cuts, int ranks)
    : cuts_(std::move(cuts)), n_(ranks) {
  for (bisection_cut& c : cuts_) {
    c.at += 0.0;  // -0 becomes 0
    if (c.axis < 0 || c.axis > 2)
      detail::fail<std::invalid_argument>(
          "a cut of a bisection is across axis {}, but axes are 0, 1 and 2 for x, y and z", c.axis);
  }
  require({}, 0, n_);
}

TALUS_INLINE int bisection_cells::owner(const vec3& p) const {
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

TALUS_INLINE std::vector<int> bisection_cells::neighbours(int rank, real reach) const {
  std::vector<int> ranks;
  collect(box(rank), reach, {}, 0, 0, n_, ranks);
  std::erase(ranks, rank);
  return ranks;
}

TALUS_INLINE any_geometry bisection_cells::geometry(int rank) const {
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

TALUS_INLINE grid_cells::cell_bounds bisection_cells::cell(int rank) const {
  const detail::part_of_space own = box(rank);
  return {own.lower, own.upper};
}

TALUS_INLINE detail::part_of_space bisection_cells::box(int rank) const {
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

TALUS_INLINE void bisection_cells::collect(const detail::part_of_space& own, real reach,
                                           const detail::part_of_space& part, std::size_t cut,
                                           int first, int n, std::vector<int>& ranks) const {
  if (!own.near(part, reach)) return;
  if (n == 1) return ranks.push_back(first);
  const int below = detail::ranks_below(n);
  collect(own, reach, part.below(cuts_[cut]), cut + 1, first, below, ranks);
  collect(own, reach, part.above(cuts_[cut]), cut + static_cast<std::size_t>(below), first + below,
          n - below, ranks);
}

TALUS_INLINE void bisection_cells::require(const detail::part_of_space& part, std::size_t cut,
                                           int n) const {
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

}  // namespace talus
