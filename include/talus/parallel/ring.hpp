#pragma once
// Sectors about an axis, connected in sequence: stairs, silos, couette cells, mills.
#include <algorithm>
#include <string>
#include <vector>

#include "talus/core/field_names.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/parallel/detail/convex_pieces.hpp"
#include "talus/parallel/detail/directions.hpp"
#include "talus/parallel/dynamic.hpp"

namespace talus {

/// Sectors between known half-planes that end at an axis. Both ranks test the side of a point
/// against one stored half_space per boundary, so that no sine or cosine is computed twice; a point
/// on a boundary belongs to the side towards +x (then +y, +z). Sectors touch in sequence; the axis,
/// where all of them meet, is closed.
class ring_cells {
 public:
  /// The half-plane where a sector starts.
  struct boundary {
    half_space plane;  ///< The normal points towards higher ranks.
    real angle;        ///< From the first boundary, which has 0.
  };

  /// Sector k lies between the boundaries k and k + 1, the last one ends at the first boundary. No
  /// sector is wider than half a turn. `closed_end`: the last sector is not connected to the first.
  ring_cells(std::vector<boundary> boundaries, real hub, bool closed_end);

  [[nodiscard]] int size() const { return static_cast<int>(boundaries_.size()); }

  [[nodiscard]] int owner(const vec3& point) const;

  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const;
  /// The other sectors, which meet this one at the axis, or at the closed end.
  [[nodiscard]] std::vector<int> closed(int rank) const {
    return select(rank, [&](int other) { return !in_sequence(rank, other); });
  }
  [[nodiscard]] any_geometry geometry(int rank) const { return any_geometry::cell(planes(rank)); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const;

 private:
  static std::ptrdiff_t offset(std::size_t i) { return static_cast<std::ptrdiff_t>(i); }
  [[nodiscard]] const boundary& at(int sector) const {
    return boundaries_[static_cast<std::size_t>(sector)];
  }
  void require(int rank) const;
  template <class Test>
  [[nodiscard]] std::vector<int> select(int rank, Test&& test) const {
    require(rank);
    std::vector<int> ranks;
    for (int other = 0; other < size(); ++other)
      if (other != rank && test(other)) ranks.push_back(other);
    return ranks;
  }
  [[nodiscard]] bool in_sequence(int a, int b) const;
  /// The angle between two sectors, on the shorter way that is not closed.
  [[nodiscard]] real gap(int a, int b) const;
  [[nodiscard]] detail::convex_piece planes(int rank) const;

  std::vector<boundary> boundaries_;
  std::size_t half_ = 0;  // the last boundary within half a turn of the first
  real hub_;
  bool closed_end_;
};

/// N sectors of equal angle about an axis, counter-clockwise seen against the axis. Each sector is
/// connected to the one before and the one after. A fixed body in the middle (the hub) keeps bodies
/// away from the axis, where all sectors meet; a body whose bounds reach a sector without a
/// connection to its own ends the run. If the sectors cover part of the circle, the first and the
/// last one share the rest of space, each up to its middle.
///   ring<6>{}                                                  sixths of the circle about z
///   ring<6>{.axis = {0, 0, -1}, .start = {-1, 0, 0}, .angle = pi}      from -x over +y to +x
///   ring<dynamic>{.hub = 6}                                    as many sectors as there are ranks
template <int N>
struct ring {
  using talus_fields = detail::fields::ring_fields;
  static_assert(N >= 1 || N == dynamic,
                "ring<N> takes the number of sectors, 1 or more, or ring<dynamic>");

  int sectors = 0;       ///< Sectors of ring<dynamic>; 0: as follows from the number of ranks.
  vec3 axis{0, 0, 1};    ///< Direction of the axis; any length but zero.
  vec3 centre{0, 0, 0};  ///< A point of the axis.
  vec3 start{1, 0, 0};   ///< Where sector 0 starts, as a direction from the axis.
  real angle = 2 * pi;   ///< Angle of all sectors together (radians), up to the full circle.
  /// Radius of the body in the middle (length). Distances between sectors, for reach{...}, are
  /// those outside of it.
  real hub = 0;
  /// Whether the face between the last sector and the first is closed: no connection there.
  bool closed = false;

  /// The number of ranks, 0 while it is open.
  [[nodiscard]] int size() const {
    return detail::chosen_size("ring", "sectors", N, sectors, 0, 1);
  }

  [[nodiscard]] ring_cells resolve(int ranks) const {
    const int n = size() > 0 ? size() : ranks;
    if (n != ranks)
      detail::fail<std::invalid_argument>(
          "a ring of {} sectors needs exactly {} ranks, but there are {}: start the program with "
          "that many, or use ring<dynamic>, which fits any number",
          n, n, ranks);
    if (!(angle > 0 && angle <= 2 * pi * (1 + 1e-12)))
      detail::fail<std::invalid_argument>(
          "the .angle of a ring must be above 0 and at most the full circle, 2 pi = {}, but is {}",
          2 * pi, angle);
    if (!detail::finite(centre) || !std::isfinite(hub) || hub < 0)
      detail::fail<std::invalid_argument>(
          "a ring needs a finite .centre and a .hub of finite radius >= 0, but they are {} and {}",
          detail::text(centre), hub);

    const detail::axis_frame frame("ring", axis, start);
    const bool full = angle >= 2 * pi * (1 - 1e-12);
    std::vector<ring_cells::boundary> boundaries;
    const auto begin = [&](real at, real from_first) {
      const vec3 normal = frame.towards(detail::turn(at + pi / 2));
      boundaries.push_back({half_space(normal, centre), from_first});
    };
    const real first = full ? 0 : angle / 2 - pi;  // in the middle of what is left of the circle
    begin(first, 0);
    for (int k = 1; k < n; ++k) begin(angle * k / n, angle * k / n - first);
    // Two halves of one plane have one normal.
    if (full || n == 2)
      for (std::size_t k = 0, half = boundaries.size() / 2; n % 2 == 0 && k < half; ++k)
        boundaries[half + k].plane = boundaries[k].plane.flipped();
    return {std::move(boundaries), hub, closed};
  }
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/ring_definitions.hpp"
#endif
