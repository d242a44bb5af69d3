#pragma once
// Volume and moments of what a convex part of a union shares with other parts: lines through the
// parts, whose lengths are exact, and an adaptive rule (Gauss and Kronrod, 7 and 15 points) over
// the places of the lines. The same numbers on every rank, since nothing depends on the machine.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"
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

/// The integral of f over an interval, halved until the two rules agree within `tolerance` (of
/// moments in units of `size`), or `depth` times.
template <class F>
[[nodiscard]] ten_moments integral(real from, real to, real tolerance, int depth, F&& f) {
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
  if (error <= tolerance || depth == 0) return fine;
  ten_moments sum = integral(from, middle, tolerance, depth - 1, f);
  const ten_moments second = integral(middle, to, tolerance, depth - 1, f);
  for (std::size_t m = 0; m < 10; ++m) sum[m] += second[m];
  return sum;
}

/// What a part shares with others, about the origin of the frame `at` of the part: half extents of
/// the part in its frame, and a function that gives the chord of the part (number 0) and of the
/// others, up to `count`, along the x axis of that frame. `lower` and `upper` bound the others in
/// it.
template <class Chords>
[[nodiscard]] mass_moments<real> shared_by_parts(const vec3& half, vec3 lower, vec3 upper,
                                                 std::size_t count, Chords&& chord_at) {
  lower = lower.cwiseMax(vec3(-half)), upper = upper.cwiseMin(half);
  mass_moments<real> sum;
  for (int k = 0; k < 3; ++k)
    if (!(upper[k] > lower[k])) return sum;
  const real size = std::max({half[0], half[1], half[2]});
  std::vector<chord> inside;
  const auto along_line = [&](real y, real z) {
    ten_moments m{};
    const chord own = chord_at(0, vec3(0, y, z));
    if (own.empty()) return m;
    inside.clear();
    for (std::size_t n = 1; n < count; ++n) {
      const chord c = detail::shared(own, chord_at(n, vec3(0, y, z)));
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
  // Panels find what is small in a large box.
  constexpr int panels = 4, depth = 24;
  constexpr real tolerance = 1e-7;
  const real box = half[0] * half[1] * half[2] / (size * size * size);
  const auto over = [&](real from, real to, real allowed, auto&& f) {
    ten_moments all{};
    for (int k = 0; k < panels; ++k) {
      const ten_moments one = integral(from + (to - from) * k / panels,
                                       from + (to - from) * (k + 1) / panels, allowed, depth, f);
      for (std::size_t m = 0; m < 10; ++m) all[m] += one[m];
    }
    return all;
  };
  const real deep = (upper[2] - lower[2]) / size;
  const ten_moments m = over(lower[2] / size, upper[2] / size, tolerance * box, [&](real z) {
    return over(lower[1] / size, upper[1] / size, tolerance / 10 * box / deep,
                [&](real y) { return along_line(y * size, z * size); });
  });
  const real volume = size * size * size;
  sum.mass = volume * m[0];
  sum.first = volume * size * vec3(m[1], m[2], m[3]);
  sum.second = volume * size * size * mat3(m[4], m[9], m[8], m[9], m[5], m[7], m[8], m[7], m[6]);
  return sum;
}

}  // namespace talus::detail
