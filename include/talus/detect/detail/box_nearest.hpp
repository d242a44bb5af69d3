#pragma once
// Single contacts of two boxes: the nearest points when apart, the crossing edges when overlapping.
#include "talus/detect/detail/box_axes.hpp"

namespace talus::detail {

/// A point of each of two lines, given by a point and a unit direction each, nearest to the other
/// line; `s` and `t` are their positions on the lines. Returns false if the lines are parallel.
template <class Real>
bool nearest_on_lines(const vector3<Real>& p, const vector3<Real>& u, const vector3<Real>& q,
                      const vector3<Real>& v, Real& s, Real& t) {
  const vector3<Real> d = q - p;
  const Real uv = u.dot(v);
  const Real square = u.cross(v).squaredNorm();
  if (square < Real(1e-8)) return false;
  const Real du = d.dot(u), dv = d.dot(v);
  s = (du - uv * dv) / square;
  t = (uv * du - dv) / square;
  return true;
}

/// The foremost edges of two boxes along an edge axis, and the points of them that are nearest to
/// the line of the other: `middle + s along`, within the edge.
template <class Real>
struct edge_crossing {
  vector3<Real> middle_a = vector3<Real>::Zero(), middle_b = vector3<Real>::Zero();
  vector3<Real> along_a, along_b;
  Real s = 0, t = 0;
  Real half_a, half_b, sine_square;
  box_part part_a = 0, part_b = 0;

  edge_crossing(const box_pair<Real>& p, const box_axis<Real>& e)
      : half_a(p.ha[e.i]), half_b(p.hb[e.j]) {
    const vector3<Real> inwards = p.axes.transpose() * -e.normal;
    for (int d = 1; d < 3; ++d) {
      const int u = (e.i + d) % 3, k = (e.j + d) % 3;
      middle_a[u] = e.normal[u] > 0 ? p.ha[u] : -p.ha[u];
      middle_b[k] = inwards[k] > 0 ? p.hb[k] : -p.hb[k];
      part_a |= side(u, e.normal[u] > 0);
      part_b |= side(k, inwards[k] > 0);
    }
    along_a = vector3<Real>::Unit(e.i), along_b = column_of(p.axes, e.j);
    middle_b = p.from_b(middle_b);
    nearest_on_lines(middle_a, along_a, middle_b, along_b, s, t);
    s = std::clamp(s, -half_a, half_a), t = std::clamp(t, -half_b, half_b);
    sine_square = along_a.cross(along_b).squaredNorm();
  }
  /// Whether the points lie so far inside the edges that the ends of the edges are clearly farther
  /// from each other than the points, which are `gap` apart.
  [[nodiscard]] bool inside(Real gap) const {
    const auto within = [&](Real at, Real half) {
      const Real left = half - std::abs(at);
      return left > 0 && left * left * sine_square > Real(1e-8) * gap * gap;
    };
    return within(s, half_a) && within(t, half_b);
  }
  /// The square of the distance of the two points.
  [[nodiscard]] Real square() const {
    return (middle_b + t * along_b - (middle_a + s * along_a)).squaredNorm();
  }
};

/// Nearest points of two separated boxes, with `axes.best()` clearly above zero. If the boxes are
/// farther apart than the margin, so is the returned gap. The nearest points are a corner and the
/// point nearest to it, or the interiors of two edges, so testing these is exact. Corners and edges
/// too far behind the best axis are skipped: farther than the nearest of the foremost ones.
template <class Real>
box_contact<Real> nearest_points(const box_pair<Real>& p, const box_axes<Real>& axes, Real margin) {
  const box_axis<Real>& axis = axes.edge.gap > std::max(axes.face_a.gap, axes.face_b.gap)
                                   ? axes.edge
                               : axes.face_b.gap > axes.face_a.gap ? axes.face_b
                                                                   : axes.face_a;
  constexpr Real closer = 1 - Real(1e-9);  // of nearly equal candidates, the first
  const Real limit = margin * (1 + Real(1e-6)) + Real(1e-12) * p.smallest();
  Real best = limit * limit;
  vector3<Real> on_a = vector3<Real>::Zero(), on_b = vector3<Real>::Zero();
  box_contact<Real> found;
  const auto offer = [&](const vector3<Real>& x, const vector3<Real>& y, box_part a, box_part b) {
    const Real square = (y - x).squaredNorm();
    if (!(square < best * closer)) return;
    best = square;
    on_a = x, on_b = y, found.a = a, found.b = b;
  };
  const auto finished = [&] {
    if (!(best < limit * limit)) {
      found.gap = limit + limit + Real(1e-300);
      return found;
    }
    found.gap = std::sqrt(best);
    found.normal = (on_b - on_a) / found.gap;
    found.point = Real(0.5) * (on_a + on_b);
    return found;
  };
  // Edges that cross well inside each other along the best axis: that gap is the distance.
  Real crossing = best;
  if (&axis == &axes.edge) {
    const edge_crossing<Real> x(p, axis);
    crossing = x.square();
    if (x.inside(axis.gap)) {
      offer(x.middle_a + x.s * x.along_a, x.middle_b + x.t * x.along_b, x.part_a, x.part_b);
      return finished();
    }
  }
  const vector3<Real> inwards = p.axes.transpose() * -axis.normal;
  // How far a corner lies behind the foremost one of its box.
  const auto behind = [](const vector3<Real>& half, const vector3<Real>& normal, unsigned c) {
    Real sum = 0;
    for (int i = 0; i < 3; ++i)
      if ((normal[i] > 0) != bool(c >> i & 1u)) sum += 2 * std::abs(normal[i]) * half[i];
    return sum;
  };
  const auto foremost = [](const vector3<Real>& half, const vector3<Real>& normal) {
    return vector3<Real>{normal[0] > 0 ? half[0] : -half[0], normal[1] > 0 ? half[1] : -half[1],
                         normal[2] > 0 ? half[2] : -half[2]};
  };
  const vector3<Real> corner_a = p.to_b(foremost(p.ha, axis.normal)),
                      corner_b = p.from_b(foremost(p.hb, inwards));
  Real enough =
      std::min({crossing, (corner_b - corner_b.cwiseMax(-p.ha).cwiseMin(p.ha)).squaredNorm(),
                (corner_a - corner_a.cwiseMax(-p.hb).cwiseMin(p.hb)).squaredNorm()});
  enough *= 1 + Real(1e-8);  // those that are nearly as near stay
  const auto too_far = [&](Real bound) {
    return bound > 0 && bound * bound >= std::min(best, enough);
  };
  for (unsigned c = 0; c < 8; ++c) {
    const Real bound = axis.gap + behind(p.hb, inwards, c);
    if (too_far(bound)) continue;
    const vector3<Real> y = p.from_b(corner_of(p.hb, c));
    offer(y.cwiseMax(-p.ha).cwiseMin(p.ha), y, nearest_part(p.ha, y), corner_part(c));
  }
  for (unsigned c = 0; c < 8; ++c) {
    const Real bound = axis.gap + behind(p.ha, axis.normal, c);
    if (too_far(bound)) continue;
    const vector3<Real> x = corner_of(p.ha, c), seen = p.to_b(x);
    offer(x, p.from_b(seen.cwiseMax(-p.hb).cwiseMin(p.hb)), corner_part(c),
          nearest_part(p.hb, seen));
  }

  // Edges whose nearer end is near enough, and how far that lies behind.
  struct edge {
    int axis;
    Real behind;
    vector3<Real> middle;
    box_part part;
  };
  const auto edges_of = [&](const vector3<Real>& half, const vector3<Real>& normal, edge* out) {
    int count = 0;
    for (int i = 0; i < 3; ++i) {
      const int u = (i + 1) % 3, v = (i + 2) % 3;
      const Real step_u = 2 * std::abs(normal[u]) * half[u],
                 step_v = 2 * std::abs(normal[v]) * half[v];
      for (int k = 0; k < 4; ++k) {
        const bool up = k & 1, vp = k & 2;
        const Real behind =
            ((normal[u] > 0) == up ? 0 : step_u) + ((normal[v] > 0) == vp ? 0 : step_v);
        const Real bound = axis.gap + behind;
        if (too_far(bound)) continue;
        edge& e = out[count++];
        e.axis = i, e.behind = behind, e.part = side(u, up) | side(v, vp);
        e.middle[i] = 0;
        e.middle[u] = up ? half[u] : -half[u];
        e.middle[v] = vp ? half[v] : -half[v];
      }
    }
    return count;
  };
  edge of_a[12], of_b[12];
  const int count_a = edges_of(p.ha, axis.normal, of_a), count_b = edges_of(p.hb, inwards, of_b);
  for (int ka = 0; ka < count_a; ++ka)
    for (int kb = 0; kb < count_b; ++kb) {
      const edge &ea = of_a[ka], &eb = of_b[kb];
      const Real bound = axis.gap + ea.behind + eb.behind;
      if (too_far(bound)) continue;
      const vector3<Real> u = vector3<Real>::Unit(ea.axis), v = column_of(p.axes, eb.axis),
                          middle = p.from_b(eb.middle);
      Real s, t;
      if (!nearest_on_lines(ea.middle, u, middle, v, s, t)) continue;
      if (std::abs(s) > p.ha[ea.axis] || std::abs(t) > p.hb[eb.axis]) continue;
      offer(ea.middle + s * u, middle + t * v, ea.part, eb.part);
    }
  return finished();
}

/// The two edges that cross along the best edge axis of boxes which touch or overlap.
template <class Real>
box_contact<Real> crossing_edges(const box_pair<Real>& p, const box_axes<Real>& axes) {
  const edge_crossing<Real> x(p, axes.edge);
  box_contact<Real> found;
  found.a = x.part_a, found.b = x.part_b;
  found.normal = axes.edge.normal;
  found.point = Real(0.5) * (x.middle_a + x.s * x.along_a + x.middle_b + x.t * x.along_b);
  found.gap = axes.edge.gap;
  return found;
}

}  // namespace talus::detail
