#pragma once
// The definitions of ring.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/ring.hpp"

namespace talus {

TALUS_INLINE ring_cells::ring_cells(std::vector<boundary> boundaries, real hub, bool closed_end)
    : boundaries_(std::move(boundaries)), hub_(hub), closed_end_(closed_end) {
  while (half_ + 1 < boundaries_.size() && boundaries_[half_ + 1].angle < pi - 1e-12) ++half_;
}

TALUS_INLINE int ring_cells::owner(const vec3& point) const {
  if (detail::has_nan(point)) return -1;
  if (size() == 1) return 0;
  const vec3 p = detail::bounded(point);
  // In the first half turn the last boundary behind the point, else the last one of the others.
  const bool first_half = boundaries_[0].plane.owns(p);
  const auto from = boundaries_.begin() + (first_half ? 1 : offset(half_ + 1));
  const auto to = first_half ? boundaries_.begin() + offset(half_ + 1) : boundaries_.end();
  const auto next =
      std::partition_point(from, to, [&](const boundary& b) { return b.plane.owns(p); });
  return static_cast<int>(next - boundaries_.begin()) - 1;
}

TALUS_INLINE std::vector<int> ring_cells::neighbours(int rank, real reach) const {
  return select(rank, [&](int other) {
    if (in_sequence(rank, other)) return true;
    if (!(reach > 0)) return false;
    // Between the points of the two sectors on the hub that are nearest to each other.
    const real narrow = std::min(gap(rank, other), pi);
    return 2 * hub_ * portable::sin(narrow / 2) <= reach * (1 + 1e-12);
  });
}

TALUS_INLINE std::pair<vec3, vec3> ring_cells::bounds(int rank) const {
  const auto cell = planes(rank);
  return detail::bounds_of({&cell, 1});
}

TALUS_INLINE void ring_cells::require(int rank) const {
  if (rank < 0 || rank >= size())
    detail::fail<std::invalid_argument>("there is no rank {} in a ring of {} sectors", rank,
                                        size());
}

TALUS_INLINE bool ring_cells::in_sequence(int a, int b) const {
  const int apart = std::abs(a - b);
  return apart == 1 || (apart == size() - 1 && !closed_end_);
}

TALUS_INLINE real ring_cells::gap(int a, int b) const {
  const int low = std::min(a, b), high = std::max(a, b);
  const real across = at(high).angle - at(low + 1).angle;
  if (closed_end_) return across;
  const real end = high + 1 < size() ? at(high + 1).angle : 2 * pi;
  return std::min(across, 2 * pi - end + at(low).angle);
}

TALUS_INLINE detail::convex_piece ring_cells::planes(int rank) const {
  require(rank);
  if (size() == 1) return {};
  return {at(rank).plane, at((rank + 1) % size()).plane.flipped()};
}

}  // namespace talus
