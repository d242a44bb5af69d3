#pragma once
// The separating axis test of two boxes (Gottschalk, Lin, Manocha 1996), with the gap along each.
#include "talus/detect/detail/box_frame.hpp"

namespace talus::detail {

/// An axis and the gap of the two boxes along it: a lower bound of their distance. The largest of
/// all is minus the penetration depth when the boxes overlap.
template <class Real>
struct box_axis {
  Real gap = -std::numeric_limits<Real>::infinity();
  vector3<Real> normal{0, 0, 0};  // unit, in the frame of a, from a towards b
  int i = 0, j = 0;               // a face's axis is i; of edges, a's direction is i and b's is j
};

template <class Real>
struct box_axes {
  box_axis<Real> face_a, face_b, edge;  // the best of each kind
  bool apart = false;                   // some gap exceeds the margin; nothing else is set then

  box_axes(const box_pair<Real>& p, Real margin) {
    const matrix3<Real> shadow = p.axes.cwiseAbs();
    const vector3<Real> seen_from_b = p.axes.transpose() * p.offset;
    for (int i = 0; i < 3; ++i) {
      const Real gap = std::abs(p.offset[i]) - p.ha[i] - shadow.row(i).dot(p.hb);
      if (gap > face_a.gap) face_a.gap = gap, face_a.i = i;
    }
    if ((apart = face_a.gap > margin)) return;
    for (int i = 0; i < 3; ++i) {
      const Real gap = std::abs(seen_from_b[i]) - p.hb[i] - shadow.col(i).dot(p.ha);
      if (gap > face_b.gap) face_b.gap = gap, face_b.i = i;
    }
    if ((apart = face_b.gap > margin)) return;
    for (int i = 0; i < 3; ++i) {
      const int u = (i + 1) % 3, v = (i + 2) % 3;
      for (int j = 0; j < 3; ++j) {
        // e_i x b_j = (0, -b_v, b_u) in the axes i, u, v. Parallel edges give no axis of their own.
        const Real square = p.axes(u, j) * p.axes(u, j) + p.axes(v, j) * p.axes(v, j);
        if (square < Real(1e-8)) continue;
        const int k = (j + 1) % 3, l = (j + 2) % 3;
        const Real along = p.axes(u, j) * p.offset[v] - p.axes(v, j) * p.offset[u];
        const Real radii = p.ha[u] * shadow(v, j) + p.ha[v] * shadow(u, j) +
                           p.hb[k] * shadow(i, l) + p.hb[l] * shadow(i, k);
        const Real gap = (std::abs(along) - radii) / std::sqrt(square);
        if (gap > edge.gap) edge.gap = gap, edge.i = i, edge.j = j;
      }
    }
    if ((apart = edge.gap > margin)) return;

    face_a.normal[face_a.i] = p.offset[face_a.i] < 0 ? -1 : 1;
    face_b.normal = p.axes.col(face_b.i);
    if (seen_from_b[face_b.i] < 0) face_b.normal = -face_b.normal;
    edge.normal = vector3<Real>::Unit(edge.i).cross(p.axes.col(edge.j)).normalized();
    if (edge.normal.dot(p.offset) < 0) edge.normal = -edge.normal;
  }

  [[nodiscard]] Real best() const { return std::max({face_a.gap, face_b.gap, edge.gap}); }
};

}  // namespace talus::detail
