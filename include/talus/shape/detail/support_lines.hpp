#pragma once
// Lines and planes through a convex shape, by its support function h(u), the largest u . x of its
// points x: the least upper bound of all directions that bound the line or the plane.
#include <algorithm>
#include <cmath>
#include <concepts>

#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"

namespace talus::detail {

/// The least value of a convex function of all numbers c, given as f(w, t) for c = t / w: by the
/// golden section over c = t / (1 - t^2).
template <class F>
[[nodiscard]] real least_of(F&& f) {
  constexpr real golden = 0.6180339887498949;
  const auto value = [&](real t) { return f(1 - t * t, t); };
  real from = -1, to = 1;
  real a = to - golden * (to - from), b = from + golden * (to - from);
  real at_a = value(a), at_b = value(b);
  for (int k = 0; k < 44; ++k) {
    if (at_a < at_b) {
      to = b, b = a, at_b = at_a;
      a = to - golden * (to - from), at_a = value(a);
    } else {
      from = a, a = b, at_a = at_b;
      b = from + golden * (to - from), at_b = value(b);
    }
  }
  return std::min(at_a, at_b);
}

/// The values of y that a convex shape has in the plane z, or a little more: the upper end is the
/// least of h(0, 1, c) - c z over all c.
template <class Support>
[[nodiscard]] chord range_in_plane(real z, Support&& h) {
  const auto top = [&](real sign) {
    return least_of([&](real w, real t) { return (h(vec3(0, sign * w, t)) - t * z) / w; });
  };
  return {-top(-1), top(1)};
}

/// The chord of a convex shape without a function for it, or a little more: the upper end is the
/// least of h(u) - u . p over all u with u . d = 1.
template <class Shape>
[[nodiscard]] chord chord_by_support(const Shape& s, const vec3& p, const vec3& d) {
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(d[k]) < std::abs(d[least])) least = k;
  const vec3 e = unit(d.cross(vec3::Unit(least))), f = unit(d.cross(e));
  const auto top = [&](real sign) {
    const vec3 along = (sign / d.dot(d)) * d;
    return least_of([&](real w, real t) {
      const vec3 first = along + (t / w) * e;
      return least_of([&](real v, real r) {
        const vec3 u = v * first + r * f;
        return u.dot(s.support(u) - p) / v;
      });
    });
  };
  return {-top(-1), top(1)};
}
template <class Shape>
[[nodiscard]] chord chord_of(const Shape& s, const vec3& p, const vec3& d) {
  if constexpr (requires {
                  { s.chord(p, d) } -> std::same_as<chord>;
                })
    return s.chord(p, d);
  else
    return chord_by_support(s, p, d);
}

}  // namespace talus::detail
