#pragma once
// The normal of two convex bodies of which at least one is smooth, to the last digits: the unit
// vector n along which their gap n.(a(-n) - b(n)), of support points a and b, is largest. Newton's
// method on the unit sphere. Where bodies are apart, every such vector is the direction of the
// nearest points.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "talus/detect/detail/common_normal.hpp"
#include "talus/detect/detail/convex_distance.hpp"

namespace talus::detail {

/// A symmetric matrix of two rows.
template <class Real>
struct symmetric_2 {
  Real aa = 0, ab = 0, bb = 0;
};

enum class climbed { beyond, summit, lost };

/// The state of a search for the best normal.
template <class Real>
struct summit_of {
  climbed state = climbed::lost;
  vector3<Real> normal{0, 0, 0};
  Real gap = 0;
  difference_point<Real> at;  ///< the support points along the normal
};

/// The best normal near `start`, after 30 steps at most. `pair.at(n)` gives the support points
/// along n with their difference, from which a component along `line` (a unit vector, or zero) is
/// removed; normals stay across the line. `pair.bend(n, p, t, u)` gives minus the derivative of the
/// difference along the tangents t and u. The result is `beyond` as soon as the gap of any normal
/// is above `limit`, and `found` as soon as the two points are less than `near` (a length) apart
/// across the normal; `lost` if this is no maximum, with the difference along the normal within
/// 1e-10 of `scale` (a length). The normal is as exact as rounding errors allow: they turn it by
/// that of the difference over the smallest radius of curvature plus the gap.
template <class Real, class Pair>
[[nodiscard]] summit_of<Real> climb(const Pair& pair, const vector3<Real>& start,
                                    const vector3<Real>& line, Real limit, Real scale,
                                    Real near = 0) {
  using vector = vector3<Real>;
  const bool bound = line.squaredNorm() > 0;
  const auto unit_across = [&](const vector& v) {
    return (bound ? vector(v - line.dot(v) * line) : v).normalized();
  };
  summit_of<Real> found;
  found.normal = unit_across(start);
  found.at = pair.at(found.normal);
  found.gap = found.normal.dot(found.at.w);
  const Real least = Real(4e-16) * scale;
  Real last = std::numeric_limits<Real>::infinity(), turn = last;
  for (int k = 0; k < 30; ++k) {
    if (found.gap > limit) {
      found.state = climbed::beyond;
      return found;
    }
    const vector& n = found.normal;
    const vector t =
        bound ? vector(line.cross(n))
              : vector(n.cross(vector::Unit(std::abs(n[0]) < Real(0.6) ? 0 : 1))).normalized();
    const vector u = n.cross(t);
    const Real rt = t.dot(found.at.w), ru = bound ? Real(0) : u.dot(found.at.w);
    const Real rest = std::abs(rt) + std::abs(ru);
    if (rest < near) return found;
    symmetric_2<Real> m = pair.bend(n, found.at, t, u);
    if (bound) m.ab = 0, m.bb = 1;
    const Real g = found.gap;
    const auto determinant = [&](Real shift) {
      return (m.aa + shift) * (bound ? Real(1) : m.bb + shift) - m.ab * m.ab;
    };
    // Below zero, the gap lowers the curvature of the function: away from its maximum it is added.
    const bool summit = determinant(g) > 0 && m.aa + g > 0;
    const bool peak = summit && (g >= 0 || determinant(g) > Real(1e-3) * determinant(0));
    const Real shift = peak ? g : std::abs(g) + Real(1e-3) * scale;
    const Real d = determinant(shift), sb = bound ? Real(1) : m.bb + shift;
    vector step = ((sb * rt - m.ab * ru) / d) * t;
    if (!bound) step += (((m.aa + shift) * ru - m.ab * rt) / d) * u;
    const Real length = step.norm();
    // The step is the error of the normal: a sharp tip needs a smaller rest than a flat side.
    const bool near = rest < Real(1e-10) * scale,
               exact = rest < Real(1e-13) * scale && length < Real(1e-12);
    if (rest <= least || (near && (exact || !(rest < Real(0.5) * last) || !(length < turn)))) {
      found.state = summit ? climbed::summit : climbed::lost;
      return found;
    }
    last = rest, turn = length;
    if (!(length < Real(1e10))) return found;
    if (length > Real(0.7)) step *= Real(0.7) / length;
    bool better = false;
    for (int half = 0; half < 8 && !better; ++half) {
      const vector next = unit_across(n + step);
      const difference_point<Real> p = pair.at(next);
      const Real gap = next.dot(p.w);
      if (gap >= g - Real(1e-14) * scale) {  // (less is lost in rounding errors)
        found.normal = next, found.at = p, found.gap = gap;
        better = true;
      }
      step *= Real(0.35);
    }
    if (!better) {
      found.state = near && summit ? climbed::summit : climbed::lost;
      return found;
    }
  }
  return found;
}

/// What holds the support point of a body while the normal is improved: nothing, if the body is
/// smooth; a corner; a line, along which the point is free, with a distance around it; or the
/// circle of that radius about `from`, across the line.
template <class Real>
struct held_part {
  enum class form : std::uint8_t { none, corner, line, circle } kind = form::none;
  vector3<Real> from{0, 0, 0}, to{0, 0, 0};
  Real rounding = 0;

  /// The point furthest along a direction, but for what is free.
  [[nodiscard]] vector3<Real> furthest(const vector3<Real>& direction) const {
    if (kind != form::circle) return from;
    const vector3<Real> axis = to - from;
    const vector3<Real> across = direction - (axis.dot(direction) / axis.squaredNorm()) * axis;
    return from + rounding * across.normalized();
  }
};

/// Two views, of which one may be held.
template <class Real>
struct held_pair {
  using vector = vector3<Real>;
  const convex_pair<Real>& pair;
  held_part<Real> a, b;
  vector line = vector::Zero();

  [[nodiscard]] difference_point<Real> at(const vector& n) const {
    difference_point<Real> p;
    using form = typename held_part<Real>::form;
    p.a = a.kind == form::none ? vector(pair.a.support(-n) + pair.shift) : a.furthest(-n);
    p.b = b.kind == form::none ? pair.b.support(n) : b.furthest(n);
    p.w = p.a - p.b;
    p.w -= line.dot(p.w) * line;
    return p;
  }
  /// By differences, which is good enough: it changes the number of steps, not their end. They are
  /// wider about a sharp tip, where a small one is lost in rounding errors.
  [[nodiscard]] symmetric_2<Real> bend(const vector& n, const difference_point<Real>& p,
                                       const vector& t, const vector& u) const {
    const auto along = [&](const vector& tangent) {
      vector change = (p.w - at(n + Real(1e-7) * tangent).w) / Real(1e-7);
      const Real size = p.a.cwiseAbs().maxCoeff() + p.b.cwiseAbs().maxCoeff();
      if (change.cwiseAbs().maxCoeff() < Real(1e-5) * size)
        change = (p.w - at(n + Real(1e-5) * tangent).w) / Real(1e-5);
      return change;
    };
    const vector along_t = along(t), along_u = line.squaredNorm() > 0 ? vector(0, 0, 0) : along(u);
    // (Their true matrix is positive semidefinite.)
    return {std::max(Real(0), t.dot(along_t)), Real(0.5) * (t.dot(along_u) + u.dot(along_t)),
            std::max(Real(0), u.dot(along_u))};
  }
};

/// The one or two corners of a body that bear the nearest point of a simplex most: `which` is the
/// point of that body.
template <class Real>
[[nodiscard]] held_part<Real> held_by(const simplex<Real>& corners,
                                      vector3<Real> difference_point<Real>::*which) {
  struct weighed {
    vector3<Real> at;
    Real weight;
  } all[4];
  int size = 0;
  for (int i = 0; i < corners.size(); ++i) {
    const vector3<Real>& p = corners.corner(i).*which;
    int k = 0;
    while (k < size && all[k].at != p) ++k;
    if (k == size) all[size++] = {p, 0};
    all[k].weight += corners.weight(i);
  }
  const weighed* first = nullptr;
  const weighed* second = nullptr;
  for (int k = 0; k < size; ++k)
    if (first == nullptr || all[k].weight > first->weight)
      second = first, first = all + k;
    else if (second == nullptr || all[k].weight > second->weight)
      second = all + k;
  held_part<Real> part;
  using form = typename held_part<Real>::form;
  part.kind = second != nullptr ? form::line : first != nullptr ? form::corner : form::none;
  if (first != nullptr) part.from = first->at;
  if (second != nullptr) part.to = second->at;
  return part;
}

/// Improves the nearest points of two cores, as found by distance_of() or depth_of(), if one of
/// them is smooth. Leaves them as they are where no better normal is found nearby.
template <class Real>
void sharpen(const convex_pair<Real>& pair, core_distance<Real>& best, Real scale) {
  using vector = vector3<Real>;
  using form = typename held_part<Real>::form;
  const bool of_a = !pair.a.smooth();
  const convex_view<Real>& other = of_a ? pair.a : pair.b;
  held_part<Real> part;
  if (other.round_axis(of_a ? best.on_a : best.on_b, part.from, part.to, part.rounding)) {
    const vector axis = (part.to - part.from).normalized();
    const Real along = axis.dot(best.normal);
    const bool level = std::abs(along) < Real(1e-3);
    // Over a flat end the normal is the axis. (Beside the polygon that stands for its circle.)
    if (std::abs(along) > 1 - Real(1e-7)) {
      const vector n = along < 0 ? vector(-axis) : axis;
      const vector free = of_a ? pair.b.support(n) : vector(pair.a.support(-n) + pair.shift);
      const vector away = free - part.from, below = away - axis.dot(away) * axis;
      if (below.squaredNorm() <= part.rounding * part.rounding) {
        best.normal = n, best.gap = pair.gap_along(n);
        best.on_a = of_a ? vector(part.from + below) : free;
        best.on_b = of_a ? free : vector(part.from + below);
        return;
      }
    }
    part.kind = level ? form::line : form::circle;
  } else if (!other.smooth()) {
    part = held_by(best.corners, of_a ? &difference_point<Real>::a : &difference_point<Real>::b);
    if (of_a) part.from -= best.shift, part.to -= best.shift;
  }
  // The same by the points: where a smooth body is flat, that of a normal is uncertain.
  const auto by_points = [&] {
    summit_of<Real> s;
    const convex_view<Real>& body = of_a ? pair.b : pair.a;
    if (!body.has_level() || part.kind == form::none) return s;
    const vector shift = of_a ? vector(vector::Zero()) : pair.shift;
    const bool corner = part.kind == form::corner, circle = part.kind == form::circle;
    const vector axis =
        corner ? vector(vector::Zero()) : vector((part.to - part.from).normalized());
    const round_part<Real> around{part.from - shift, axis, body.smallest(),
                                  circle ? part.rounding : Real(0)};
    common_normal<Real, convex_view<Real>, round_part<Real>> search(
        body, body.smallest(), around, around.radius, (of_a ? best.on_b : best.on_a) - shift,
        of_a ? vector(-best.normal) : best.normal, best.gap - around.radius);
    if (!search.find()) return s;
    const vector n = search.normal(), on_body = search.on_a() + shift;
    s.state = climbed::summit;
    s.normal = of_a ? vector(-n) : n;
    s.gap = search.gap() + around.radius;
    vector held = part.from;
    if (circle) {
      const vector away = on_body - s.gap * search.normal() - part.from;
      held += part.rounding * vector(away - axis.dot(away) * axis).normalized();
    }
    s.at.a = of_a ? held : on_body, s.at.b = of_a ? on_body : held;
    return s;
  };
  const Real exact = Real(1e-13) * scale;  // a length
  const auto attempt = [&] {
    held_pair<Real> search{pair, of_a ? part : held_part<Real>{}, of_a ? held_part<Real>{} : part};
    if (part.kind == form::line) search.line = (part.to - part.from).normalized();
    summit_of<Real> s =
        climb<Real>(search, best.normal, search.line, std::numeric_limits<Real>::infinity(), scale);
    const vector& w = s.at.w;
    if (s.state != climbed::summit || !((w - w.dot(s.normal) * s.normal).norm() < exact)) {
      const summit_of<Real> better = by_points();
      if (better.state == climbed::summit) s = better;
    }
    if (s.state != climbed::summit || !(s.normal.dot(best.normal) > Real(0.9))) return false;
    vector on_a = s.at.a, on_b = s.at.b;
    if (part.kind == form::line) {
      const Real along = search.line.dot((of_a ? on_b : on_a) - part.from);
      if (!(along >= 0 && along <= (part.to - part.from).norm())) return false;
      (of_a ? on_a : on_b) =
          part.from + along * search.line + (of_a ? -part.rounding : part.rounding) * s.normal;
    }
    const Real gap = s.gap - (part.kind == form::line ? part.rounding : 0);
    if (!(pair.gap_along(s.normal) >= gap - Real(1e-12) * scale)) return false;
    best.normal = s.normal, best.gap = gap, best.on_a = on_a, best.on_b = on_b;
    return true;
  };
  const auto attempt_all = [&] {
    if (attempt()) return true;
    if (part.kind != form::line) return false;
    // The nearest point is at an end of the line.
    part.kind = part.rounding > 0 ? form::circle : form::corner;
    if (attempt()) return true;
    std::swap(part.from, part.to);
    return attempt();
  };
  if (attempt_all()) return;
  // The corners may be those of a face beside the edge.
  if (!other.edge_near(of_a ? best.on_a : best.on_b, of_a ? vector(-best.normal) : best.normal,
                       part.from, part.to))
    return;
  part.kind = form::line;
  (void)attempt_all();
}

}  // namespace talus::detail
