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

  [[nodiscard]] int owner(const vec3& point) const {
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

  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const {
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
  [[nodiscard]] any_geometry geometry(int rank) const { return any_geometry::cell(planes(rank)); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const {
    const auto cell = planes(rank);
    return detail::bounds_of({&cell, 1});
  }

  /// Ranks are numbered outwards ring by ring, in each ring from `start` on towards the second
  /// direction.
  [[nodiscard]] place place_of(int rank) const {
    if (rank < 0 || rank >= size())
      detail::fail<std::invalid_argument>("there is no rank {} in {} hexagonal cells", rank,
                                          size());
    if (rank == 0) return {0, 0};
    int ring = 1;
    while (size_of(ring) <= rank) ++ring;
    const int along = rank - size_of(ring - 1);
    const place corner = steps_[along / ring], side = steps_[(along / ring + 2) % 6];
    const int k = along % ring;
    return {ring * corner.q + k * side.q, ring * corner.r + k * side.r};
  }
  [[nodiscard]] static int rank_of(const place& at) {
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
  [[nodiscard]] place guess(real u, real w) const {
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
  /// One plane for each pair of neighbours, computed identically by both.
  [[nodiscard]] detail::convex_piece planes(int rank) const {
    const place at = place_of(rank);
    detail::convex_piece result;
    for (std::size_t i = 0; i < 6; ++i) {
      if (distance({at.q + steps_[i].q, at.r + steps_[i].r}) > rings_) continue;
      const place step = steps_[i % 3];
      const place from = i < 3 ? at : place{at.q - step.q, at.r - step.r};
      const vec3& normal = normals_[i % 3];
      const real steps = from.q * step.q + from.r * step.r +
                         (from.q * step.r + from.r * step.q + 1) / real(2);  // in halves: exact
      const half_space beyond(
          normal, detail::exact_dot(normal, centre_) + detail::rounded(steps * spacing_));
      result.push_back(i < 3 ? beyond.flipped() : beyond);
    }
    return result;
  }

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

  int rings = dynamic;  ///< Of hexagonal<dynamic>; dynamic: as follows from the number of ranks.
  /// Distance of the centres of neighbouring cells, which is the width of a cell from flat to flat
  /// (length). From corner to corner a cell measures 2 / sqrt(3) of it.
  real spacing = unset;
  /// Instead of it, the width of all cells together along `start`, from flat to flat (length): that
  /// of 2 rings + 1 cells.
  real width = unset;
  vec3 centre{0, 0, 0};  ///< Of the central cell.
  vec3 axis{0, 0, 1};    ///< Of the prisms; any length but zero.
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
