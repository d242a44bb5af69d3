#pragma once
// The definitions of slabs.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/slabs.hpp"

namespace talus {

TALUS_INLINE int slab_cells::owner(const vec3& p) const {
  if (detail::has_nan(p)) return -1;
  const real at = towards_.value(detail::bounded(p));
  const auto slab = towards_.faces_up() ? std::upper_bound(cuts_.begin(), cuts_.end(), at)
                                        : std::lower_bound(cuts_.begin(), cuts_.end(), at);
  return static_cast<int>(slab - cuts_.begin());
}

TALUS_INLINE std::vector<int> slab_cells::neighbours(int rank, real reach) const {
  require(rank);
  std::vector<int> ranks;
  const auto near = [&](int below, int above) {
    const real from = upper(below), to = upper(above - 1);
    return to - from <= reach + 1e-13 * (std::abs(from) + std::abs(to));
  };
  for (int r = 0; r < size(); ++r)
    if (r != rank && near(std::min(r, rank), std::max(r, rank))) ranks.push_back(r);
  return ranks;
}

TALUS_INLINE std::pair<vec3, vec3> slab_cells::bounds(int rank) const {
  const detail::convex_piece slab = planes(rank);
  return detail::bounds_of({&slab, 1});
}

TALUS_INLINE void slab_cells::require(int rank) const {
  if (rank < 0 || rank >= size())
    detail::fail<std::invalid_argument>("there is no rank {} in {} slabs", rank, size());
}

TALUS_INLINE detail::plain_vector<half_space> slab_cells::planes(int rank) const {
  require(rank);
  detail::plain_vector<half_space> result;
  if (rank > 0) result.emplace_back(towards_.normal(), upper(rank - 1));
  if (rank + 1 < size()) result.push_back(half_space(towards_.normal(), upper(rank)).flipped());
  return result;
}

}  // namespace talus
