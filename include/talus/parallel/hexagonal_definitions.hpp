#pragma once
// The definitions of hexagonal.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/hexagonal.hpp"

namespace talus {

TALUS_INLINE int hexagonal_cells::owner(const vec3& point) const {
  if (detail::has_nan(point)) return -1;
  vec3 p = detail::bounded(point);
  const real scale = detail::largest(p) > 1e200 ? 0x1p-200 : 1;  // only directions count there
  for (int k = 0; k < 3; ++k) p[k] = p[k] * scale - centre_[k] * scale;
  const real u = detail::exact_dot(frame_.first, p) / spacing_;
  const real w = detail::exact_dot(frame_.second, p) / spacing_ * height_;

  // The nearest centre has the largest score. Scores order the cells totally, so two ranks never
  // claim the same point, and three ranks never pass a point in a circle.
  const auto score = [&](const place& at) {
    const real norm = at.q * at.q + at.q * at.r + at.r * at.r;
    return detail::rounded((at.q + at.r / real(2)) * u) + detail::rounded(at.r * w) - norm / 2;
  };
  place best = guess(u, w);
  real highest = score(best);
  for (bool moved = true; moved;) {
    moved = false;
    const place from = best;
    for (const place& step : steps_) {
      const place next{from.q + step.q, from.r + step.r};
      if (distance(next) > rings_) continue;
      const real s = score(next);
      if (s > highest || (s == highest && rank_of(next) < rank_of(best)))
        best = next, highest = s, moved = true;
    }
  }
  return rank_of(best);
}

TALUS_INLINE std::vector<int> hexagonal_cells::neighbours(int rank, real reach) const {
  const place at = place_of(rank);
  std::vector<int> ranks;
  if (reach > 0) {
    const auto own = planes(rank);
    for (int other = 0; other < size(); ++other) {
      if (other == rank) continue;
      const auto theirs = planes(other);
      if (detail::come_within(rank < other ? own : theirs, rank < other ? theirs : own, reach))
        ranks.push_back(other);
    }
    return ranks;
  }
  for (const place& step : steps_)
    if (const place next{at.q + step.q, at.r + step.r}; distance(next) <= rings_)
      ranks.push_back(rank_of(next));
  std::sort(ranks.begin(), ranks.end());
  return ranks;
}

TALUS_INLINE std::pair<vec3, vec3> hexagonal_cells::bounds(int rank) const {
  const auto cell = planes(rank);
  return detail::bounds_of({&cell, 1});
}

TALUS_INLINE hexagonal_cells::place hexagonal_cells::place_of(int rank) const {
  if (rank < 0 || rank >= size())
    detail::fail<std::invalid_argument>("there is no rank {} in {} hexagonal cells", rank, size());
  if (rank == 0) return {0, 0};
  int ring = 1;
  while (size_of(ring) <= rank) ++ring;
  const int along = rank - size_of(ring - 1);
  const place corner = steps_[along / ring], side = steps_[(along / ring + 2) % 6];
  const int k = along % ring;
  return {ring * corner.q + k * side.q, ring * corner.r + k * side.r};
}

TALUS_INLINE int hexagonal_cells::rank_of(const place& at) {
  const int ring = distance(at);
  if (ring == 0) return 0;
  const auto [q, r] = at;
  const int first = size_of(ring - 1);
  if (r == ring && q <= 0 && q > -ring) return first + ring - q;
  if (q == -ring && r > 0) return first + 2 * ring + ring - r;
  if (r == -ring && q >= 0 && q < ring) return first + 4 * ring + q;
  if (q == ring && r < 0) return first + 5 * ring + r + ring;
  return q > 0 ? first + r : first + 3 * ring - r;
}

TALUS_INLINE hexagonal_cells::place hexagonal_cells::guess(real u, real w) const {
  real r = w / (height_ * height_), q = u - r / 2;
  const real out = std::max({std::abs(q), std::abs(r), std::abs(q + r)});
  if (out > rings_) q *= rings_ / out, r *= rings_ / out;
  real nq = std::round(q), nr = std::round(r);
  const real ns = std::round(-q - r);
  const real dq = std::abs(nq - q), dr = std::abs(nr - r), ds = std::abs(ns + q + r);
  if (dq > dr && dq > ds)
    nq = -nr - ns;
  else if (dr > ds)
    nr = -nq - ns;
  const place near{static_cast<int>(nq), static_cast<int>(nr)};
  return distance(near) <= rings_ ? near : place{0, 0};
}

TALUS_INLINE detail::convex_piece hexagonal_cells::planes(int rank) const {
  const place at = place_of(rank);
  detail::convex_piece result;
  for (std::size_t i = 0; i < 6; ++i) {
    if (distance({at.q + steps_[i].q, at.r + steps_[i].r}) > rings_) continue;
    const place step = steps_[i % 3];
    const place from = i < 3 ? at : place{at.q - step.q, at.r - step.r};
    const vec3& normal = normals_[i % 3];
    const real steps = from.q * step.q + from.r * step.r +
                       (from.q * step.r + from.r * step.q + 1) / real(2);  // in halves: exact
    const half_space beyond(normal,
                            detail::exact_dot(normal, centre_) + detail::rounded(steps * spacing_));
    result.push_back(i < 3 ? beyond.flipped() : beyond);
  }
  return result;
}

}  // namespace talus
