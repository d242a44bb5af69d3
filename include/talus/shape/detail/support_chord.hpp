#pragma once
// Where a line is inside a convex shape of which the support function is all that is known.
//
// A triangle of points of the shape that the line passes through bounds the end of the chord from
// below, and each plane of support bounds it from above. The point of support in front of the
// triangle replaces one of its corners until the bounds meet (the portals of Snethen 2008); every
// other direction is that of a secant step, for which smooth shapes need few steps.
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/shape/chord.hpp"

namespace talus::detail {

/// Ends of the chords of parallel lines, for a function h(u) that returns a furthest point of a
/// convex shape along u. The origin is inside the shape; `size` is its bounding radius.
template <class Support>
class support_chord {
 public:
  /// The lines are parallel to `along`, a unit vector.
  support_chord(const Support& support, const vec3& along, real size)
      : support_(support), along_(along), small_(real(1e-12) * size) {
    int least = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(along[k]) < std::abs(along[least])) least = k;
    right_ = unit(along.cross(vec3::Unit(least)));
    up_ = along.cross(right_);
    // Inside, but in no plane of symmetry, so that no triangle is degenerate.
    middle_ = real(0.1) * support_(vec3(real(0.3) * along + real(0.5) * right_ + real(0.8) * up_));
  }

  /// The chord along the line through p.
  [[nodiscard]] chord of(const vec3& on_line) const {
    // Beside the line, which shall meet no corner and no edge of a triangle.
    const vec3 p = on_line + 3 * small_ * right_ + 2 * small_ * up_;
    const auto start = shadow_triangle(p);
    if (!start) return no_chord;
    const real middle = along_.dot(p);
    const real top = end_of(1, *start, p), bottom = end_of(-1, *start, p);
    return {-bottom - middle, top - middle};
  }

 private:
  /// A point seen along the line: its place across the line, from the line, and its height.
  struct seen {
    real x, y, height;
  };
  using triangle = std::array<seen, 3>;
  static constexpr int most_steps = 100;

  [[nodiscard]] seen view(const vec3& point, const vec3& p) const {
    return {right_.dot(point - p), up_.dot(point - p), along_.dot(point)};
  }
  [[nodiscard]] seen furthest(real x, real y, real height, const vec3& p) const {
    return view(support_(vec3(x * right_ + y * up_ + height * along_)), p);
  }
  [[nodiscard]] static real turn(const seen& a, const seen& b) { return a.x * b.y - a.y * b.x; }

  /// Three points of the shape, the line between them; none if the line misses the shape.
  [[nodiscard]] std::optional<triangle> shadow_triangle(const vec3& p) const {
    const seen middle = view(middle_, p);
    real x = -middle.x, y = -middle.y;  // from the middle of the shape to the line
    const real away = std::sqrt(x * x + y * y);
    if (away > small_)
      x /= away, y /= away;
    else
      x = 1, y = 0;
    const auto side_of = [&](const seen& q) { return x * (q.y - middle.y) - y * (q.x - middle.x); };
    // On either side of the way to the line, but not opposite to each other: a line through the
    // centre of a symmetric shape is not to meet the edge between the two.
    const auto beside = [&](real side, real turned) {
      const seen q = furthest(turned * x - side * y, turned * y + side * x, 0, p);
      return side * side_of(q) > small_ ? q : furthest(-side * y, side * x, 0, p);
    };
    seen left = beside(1, real(0.3)), right = beside(-1, real(0.1));
    for (int k = 0; k < most_steps; ++k) {
      const real ex = left.x - right.x, ey = left.y - right.y, edge = std::sqrt(ex * ex + ey * ey);
      if (!(edge > small_)) return std::nullopt;
      const real nx = ey / edge, ny = -ex / edge;  // away from the middle
      const real beyond = -(nx * left.x + ny * left.y);
      if (beyond <= 0) return triangle{middle, right, left};
      const seen next = furthest(nx, ny, 0, p);
      const real reach = nx * next.x + ny * next.y;
      if (reach <= 0 || reach + beyond <= small_) return std::nullopt;
      (side_of(next) > 0 ? left : right) = next;
    }
    return std::nullopt;
  }

  /// The height at which the line leaves the shape, in the direction of the sign.
  [[nodiscard]] real end_of(real sign, triangle corners, const vec3& p) const {
    for (seen& c : corners) c.height *= sign;
    struct sample {
      real slope_x, slope_y;
      seen point;
    };
    std::array<sample, 3> last{};
    std::size_t samples = 0;
    real lowest = height_of(corners), highest = std::numeric_limits<real>::infinity();
    for (int k = 0; k < most_steps && highest - lowest > small_; ++k) {
      // A direction (x, y, 1) or, of a steep triangle, (x, y, w).
      const auto& [a, b, c] = corners;
      real x = (b.y - a.y) * (c.height - a.height) - (b.height - a.height) * (c.y - a.y);
      real y = (b.height - a.height) * (c.x - a.x) - (b.x - a.x) * (c.height - a.height);
      real w = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
      if (!(w > 0)) break;  // the corners are counterclockwise, so they are in a line
      if (k == 0) x = y = 0, w = 1;
      if (k % 3 == 2 && samples >= 3) {
        const sample &i = last[0], &j = last[1], &l = last[2];
        const real jx = j.point.x - i.point.x, jy = j.point.y - i.point.y;
        const real lx = l.point.x - i.point.x, ly = l.point.y - i.point.y;
        const real area = jx * ly - jy * lx;
        if (std::abs(area) > small_ * small_) {
          const real u = (i.point.y * lx - i.point.x * ly) / area;
          const real v = (i.point.x * jy - i.point.y * jx) / area;
          x = i.slope_x + u * (j.slope_x - i.slope_x) + v * (l.slope_x - i.slope_x);
          y = i.slope_y + u * (j.slope_y - i.slope_y) + v * (l.slope_y - i.slope_y);
          w = 1;
        }
      }
      seen next = furthest(x, y, sign * w, p);
      next.height *= sign;
      const real round_off = real(1e-3) * small_ * (std::abs(x) + std::abs(y)) / w;
      highest = std::min(highest, next.height + (x * next.x + y * next.y) / w + round_off);
      if (samples >= 3) last[0] = last[1], last[1] = last[2];
      last[std::min<std::size_t>(samples, 2)] = {x / w, y / w, next};
      ++samples;
      enter(corners, next, lowest);
    }
    return highest < std::numeric_limits<real>::infinity() ? (lowest + highest) / 2 : lowest;
  }
  /// The height of a triangle on the line; minus infinity unless the line passes through it, up to
  /// round-off.
  [[nodiscard]] real height_of(const triangle& t) const {
    constexpr real none = -std::numeric_limits<real>::infinity();
    std::array<real, 3> part;
    real sum = 0, longest = 0;
    seen at{0, 0, 0}, edge{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const seen &from = t[k], &to = t[(k + 1) % 3];
      const seen e{to.x - from.x, to.y - from.y, to.height - from.height};
      const real square = e.x * e.x + e.y * e.y, twice = turn(from, to);
      if (twice < 0 && twice * twice > real(1e-4) * small_ * small_ * square) return none;
      if (square > longest) longest = square, edge = e;
      sum += part[k] = std::max(twice, real(0));
    }
    if (!(sum > 0)) return none;
    for (std::size_t k = 0; k < 3; ++k) {
      const seen& opposite = t[(k + 2) % 3];
      const real weight = part[k] / sum;
      at.x += weight * opposite.x, at.y += weight * opposite.y;
      at.height += weight * opposite.height;
    }
    // The weights of a thin triangle are inexact: the rest is a step along its longest edge.
    return at.height - (at.x * edge.x + at.y * edge.y) / longest * edge.height;
  }
  /// A point replaces the corner for which the line passes highest.
  void enter(triangle& corners, const seen& next, real& lowest) const {
    triangle best = corners;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle t = corners;
      t[k] = next;
      // On the other side of an edge that the line meets, the corners run the other way round.
      if ((t[1].x - t[0].x) * (t[2].y - t[0].y) < (t[1].y - t[0].y) * (t[2].x - t[0].x))
        std::swap(t[0], t[1]);
      const real height = height_of(t);
      if (height >= lowest) lowest = height, best = t;
    }
    corners = best;
  }

  const Support& support_;
  vec3 along_, right_{0, 0, 0}, up_{0, 0, 0}, middle_{0, 0, 0};
  real small_;
};

/// Whether a shape gives the chord of any line itself.
template <class Shape>
inline constexpr bool has_chord = requires(const Shape& s, const vec3& p) {
  { s.chord(p, p) } -> std::same_as<chord>;
};
/// The points p + t d inside a convex shape, d of unit length: by its member chord(), or else by
/// its support function, to 1e-9 of its bounding radius.
template <class Shape>
[[nodiscard]] chord chord_of(const Shape& s, const vec3& p, const vec3& d) {
  if constexpr (has_chord<Shape>) {
    return s.chord(p, d);
  } else {
    const auto support = [&](const vec3& u) -> vec3 { return s.support(u); };
    return support_chord(support, d, s.bounding_radius()).of(p);
  }
}

}  // namespace talus::detail
