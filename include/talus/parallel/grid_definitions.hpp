#pragma once
// The definitions of grid.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/grid.hpp"

namespace talus {

TALUS_INLINE grid_cells::grid_cells(cuts_type cuts) : cuts_(std::move(cuts)) {
  for (int axis = 0; axis < 3; ++axis) n_[axis] = static_cast<int>(cuts_[axis].size()) + 1;
}

TALUS_INLINE int grid_cells::owner(const vec3& p) const {
  if (detail::has_nan(p)) return -1;
  return index(0, p[0]) + n_[0] * (index(1, p[1]) + n_[1] * index(2, p[2]));
}

TALUS_INLINE std::vector<int> grid_cells::neighbours(int rank, real reach) const {
  const auto at = position(rank);
  std::array<int, 3> first, last;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = last[axis] = at[axis];
    // Adjacent cells always touch; the gap to further cells spans whole cells.
    while (first[axis] > 0 && lower(axis, at[axis]) - upper(axis, first[axis] - 1) <= reach)
      --first[axis];
    while (last[axis] + 1 < n_[axis] &&
           lower(axis, last[axis] + 1) - upper(axis, at[axis]) <= reach)
      ++last[axis];
  }
  std::vector<int> ranks;
  for (int iz = first[2]; iz <= last[2]; ++iz)
    for (int iy = first[1]; iy <= last[1]; ++iy)
      for (int ix = first[0]; ix <= last[0]; ++ix)
        if (const int other = ix + n_[0] * (iy + n_[1] * iz); other != rank) ranks.push_back(other);
  return ranks;
}

TALUS_INLINE any_geometry grid_cells::geometry(int rank) const {
  const auto at = position(rank);
  detail::plain_vector<half_space> planes;
  for (int axis = 0; axis < 3; ++axis) {
    const vec3 normal = vec3::Unit(axis);
    if (at[axis] > 0) planes.push_back({normal, lower(axis, at[axis])});
    if (at[axis] + 1 < n_[axis])
      planes.push_back(half_space(normal, upper(axis, at[axis])).flipped());
  }
  return any_geometry::cell(planes);
}

TALUS_INLINE auto grid_cells::cell(int rank) const -> cell_bounds {
  const auto at = position(rank);
  cell_bounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[axis] = lower(axis, at[axis]);
    bounds.upper[axis] = upper(axis, at[axis]);
  }
  return bounds;
}

TALUS_INLINE int grid_cells::index(int axis, real x) const {
  const auto& cuts = cuts_[axis];
  return static_cast<int>(std::upper_bound(cuts.begin(), cuts.end(), x) - cuts.begin());
}

TALUS_INLINE std::array<int, 3> grid_cells::position(int rank) const {
  if (rank < 0 || rank >= size())
    detail::fail<std::invalid_argument>("there is no rank {} in a grid of {} x {} x {} cells", rank,
                                        n_[0], n_[1], n_[2]);
  return {rank % n_[0], rank / n_[0] % n_[1], rank / n_[0] / n_[1]};
}

TALUS_INLINE real grid_cells::lower(int axis, int i) const {
  return i == 0 ? -std::numeric_limits<real>::infinity() : cuts_[axis][i - 1];
}

TALUS_INLINE real grid_cells::upper(int axis, int i) const {
  return i + 1 == n_[axis] ? std::numeric_limits<real>::infinity() : cuts_[axis][i];
}

}  // namespace talus

namespace talus::detail {

TALUS_INLINE bool balance(std::array<int, 3>& cells, int ranks) {
  int open = 0;
  for (const int n : cells) {
    if (n == 0)
      ++open;
    else if (ranks % n != 0)
      return false;
    else
      ranks /= n;
  }
  std::array<int, 3> best{ranks, 1, 1};
  for (int c = 1; open > 1 && c <= ranks; ++c) {
    if (ranks % c != 0 || (open == 2 && c > 1)) continue;
    for (int b = c; b * b <= ranks / c; ++b)
      if (ranks / c % b == 0 && ranks / c / b + b + c < best[0] + best[1] + best[2])
        best = {ranks / c / b, b, c};
  }
  int next = 0;
  for (int& n : cells)
    if (n == 0) n = best[next++];
  return open > 0 || ranks == 1;
}

}  // namespace talus::detail
