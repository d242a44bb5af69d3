#pragma once
// Volume and moments of what a convex part of a union shares with other parts: lines through the
// parts, whose lengths are exact, and an adaptive rule (Gauss and Kronrod, 7 and 15 points) over
// the places of the lines. The same numbers on every rank, since nothing depends on the machine.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
#include "talus/shape/detail/support_lines.hpp"
#include "talus/shape/principal_axes.hpp"

namespace talus::detail {

/// One, x, y, z, xx, yy, zz, yz, zx, xy.
using ten_moments = std::array<real, 10>;

struct kronrod_rule {
  static constexpr std::array<real, 8> nodes{
      0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
      0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
      0.586087235467691130294144045828260, 0.405845151377397166906606412076961,
      0.207784955007898467600689403773245, 0};
  static constexpr std::array<real, 8> kronrod{
      0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
      0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
      0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
      0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
  static constexpr std::array<real, 4> gauss{
      0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
      0.381830050505118944950369775488975, 0.417959183673469387755102040816327};
};

/// How exact an integral has to be, of moments in units of the size of a part.
struct line_budget {
  real tolerance = 1e-7;
  /// Lines that may be drawn; after them, intervals are not halved any more.
  std::size_t left = std::numeric_limits<std::size_t>::max();
};

/// The integral of f over an interval, halved until the two rules agree within `tolerance` (of
/// moments in units of `size`), or `depth` times, or until no lines are left.
template <class F>
[[nodiscard]] ten_moments integral(real from, real to, real tolerance, int depth,
                                   const line_budget& lines, F&& f) {
  const real middle = (from + to) / 2, half = (to - from) / 2;
  ten_moments fine{}, coarse{};
  for (std::size_t k = 0; k < 8; ++k)
    for (const real side : {-1., 1.}) {
      if (k == 7 && side > 0) break;
      const ten_moments at = f(middle + side * half * kronrod_rule::nodes[k]);
      for (std::size_t m = 0; m < 10; ++m) {
        fine[m] += kronrod_rule::kronrod[k] * at[m];
        if (k % 2 == 1) coarse[m] += kronrod_rule::gauss[k / 2] * at[m];
      }
    }
  real error = 0;
  for (std::size_t m = 0; m < 10; ++m) {
    fine[m] *= half, coarse[m] *= half;
    error = std::max(error, std::abs(fine[m] - coarse[m]));
  }
  if (error <= tolerance || depth == 0 || lines.left == 0) return fine;
  ten_moments sum = integral(from, middle, tolerance, depth - 1, lines, f);
  const ten_moments second = integral(middle, to, tolerance, depth - 1, lines, f);
  for (std::size_t m = 0; m < 10; ++m) sum[m] += second[m];
  return sum;
}

/// Where a part is in the frame in which lines are drawn.
struct part_bounds {
  vec3 lower, upper;
};

/// What a part shares with others, about the origin of the frame `at` of the part: half extents of
/// the part in its frame, the bounds of the others, and functions that give the chord along the x
/// axis of that frame and the support function h of the part (number 0) and of the others.
/// Integrals end where a part ends, in z and in y for each z: so no part is too small to be found.
/// Chords that are not exact to round-off need bounds for the lines.
template <class Chords, class Supports>
[[nodiscard]] mass_moments<real> shared_by_parts(const vec3& half,
                                                 const std::vector<part_bounds>& others,
                                                 line_budget lines, Chords&& chord_at,
                                                 Supports&& support_at) {
  mass_moments<real> sum;
  const real size = std::max({half[0], half[1], half[2]});
  std::vector<chord> inside, ranges;
  std::vector<std::size_t> here;  // the parts in a plane
  std::vector<real> ends, ends_in_plane;
  const auto along_line = [&](real y, real z) {
    ten_moments m{};
    lines.left -= lines.left > 0;
    const chord own = chord_at(0, vec3(0, y, z));
    if (own.empty()) return m;
    inside.clear();
    for (std::size_t k = 0; k < here.size(); ++k) {
      if (y < ranges[k].from || y > ranges[k].to) continue;
      const chord c = detail::shared(own, chord_at(here[k] + 1, vec3(0, y, z)));
      if (!c.empty()) inside.push_back(c);
    }
    std::sort(inside.begin(), inside.end(),
              [](const chord& a, const chord& b) { return a.from < b.from; });
    real end = own.from;
    for (const chord& c : inside) {
      const real a = std::max(end, c.from) / size, b = c.to / size;
      if (!(b > a)) continue;
      end = c.to;
      m[0] += b - a;
      m[1] += (b - a) * (b + a) / 2;
      m[4] += (b - a) * (b * b + a * b + a * a) / 3;
    }
    const real v = y / size, w = z / size;
    m[2] = v * m[0], m[3] = w * m[0], m[5] = v * m[2], m[6] = w * m[3], m[7] = v * m[3];
    m[8] = w * m[1], m[9] = v * m[1];
    return m;
  };
  constexpr int depth = 24;
  const real tolerance = lines.tolerance;
  const real box = half[0] * half[1] * half[2] / (size * size * size);
  // Of f over the intervals between neighbouring ends, unless they are of zero length.
  const auto over = [&](std::vector<real>& all, real allowed, auto&& f) {
    std::sort(all.begin(), all.end());
    ten_moments total{};
    for (std::size_t k = 0; k + 1 < all.size(); ++k) {
      if (!(all[k + 1] - all[k] > real(1e-13) * size)) continue;
      // Lengths and areas grow like square roots from the ends: over t of (3 t - t^3) / 2 they
      // grow evenly.
      const real middle = (all[k] + all[k + 1]) / (2 * size);
      const real reach = (all[k + 1] - all[k]) / (2 * size);
      const ten_moments one = integral(-1, 1, allowed, depth, lines, [&](real t) {
        ten_moments at = f(middle + reach * (t * (3 - t * t) / 2));
        for (real& m : at) m *= reach * (real(1.5) * (1 - t * t));
        return at;
      });
      for (std::size_t m = 0; m < 10; ++m) total[m] += one[m];
    }
    return total;
  };
  const auto in_plane = [&](real z, real allowed) {
    here.clear(), ranges.clear(), ends_in_plane.clear();
    const auto range_of = [&](std::size_t n) {
      return range_in_plane(z, [&](const vec3& d) { return support_at(n, d); });
    };
    const chord own = range_of(0);
    for (std::size_t n = 0; n < others.size(); ++n) {
      if (!(z > others[n].lower[2] && z < others[n].upper[2])) continue;
      const chord range = detail::shared(own, range_of(n + 1));
      if (range.empty()) continue;
      here.push_back(n), ranges.push_back(range);
      ends_in_plane.push_back(range.from), ends_in_plane.push_back(range.to);
    }
    return over(ends_in_plane, allowed, [&](real y) { return along_line(y * size, z); });
  };
  real lowest = half[2], highest = -half[2];
  for (const part_bounds& o : others)
    for (const real z : {o.lower[2], o.upper[2]}) {
      ends.push_back(std::clamp(z, -half[2], half[2]));
      lowest = std::min(lowest, ends.back()), highest = std::max(highest, ends.back());
    }
  if (!(highest > lowest)) return sum;
  // Where bounds overlap and shapes hardly do, panels find what they share.
  constexpr int panels = 4;
  for (int k = 1; k < panels; ++k) ends.push_back(lowest + (highest - lowest) * k / panels);
  const real deep = (highest - lowest) / size;
  const ten_moments m = over(ends, tolerance * box, [&](real z) {
    return in_plane(z * size, tolerance / 10 * box / deep);
  });
  const real volume = size * size * size;
  sum.mass = volume * m[0];
  sum.first = volume * size * vec3(m[1], m[2], m[3]);
  sum.second = volume * size * size * mat3(m[4], m[9], m[8], m[9], m[5], m[7], m[8], m[7], m[6]);
  return sum;
}

}  // namespace talus::detail
