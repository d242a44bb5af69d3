#pragma once
// The separating axis test of two boxes (Gottschalk, Lin, Manocha 1996), with the gap along each
// axis, for one pair or eight side by side.
#include "talus/detect/detail/box_frame.hpp"

namespace talus::detail {

// Without AVX-512 eight reals are several registers, and compilers remark on how such arguments are
// passed; all functions here are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The largest gap along the axes of each kind: a lower bound of the distance; the largest of all
/// is minus the penetration depth when the boxes overlap. `Number` is a real or several of them.
template <class Number>
struct box_gaps {
  Number face_a, axis_a;  ///< of the faces of a, and the number of the axis
  Number face_b, axis_b;
  Number edge, axes;  ///< of pairs of edges i, j, the square of the gap, with its sign, and 3 i + j
};

/// Boxes a and b, with half edges ha and hb, in the frame of a: the axes of b are the columns of c,
/// its centre is d. With `stop` (for single numbers) the rest is left out once a gap exceeds the
/// margin.
template <bool Stop, class Number>
[[nodiscard]] [[gnu::always_inline]] inline box_gaps<Number> find_box_gaps(const Number* ha,
                                                                           const Number* hb,
                                                                           const Number (*c)[3],
                                                                           const Number* d,
                                                                           const Number& margin) {
  const auto magnitude = [](const Number& x) { return x < 0 ? -x : x; };
  const Number zero{};
  box_gaps<Number> best;
  best.face_a = best.face_b = best.edge = zero - std::numeric_limits<double>::infinity();
  best.axis_a = best.axis_b = best.axes = zero;
  Number shadow[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) shadow[i][j] = magnitude(c[i][j]);
  for (int i = 0; i < 3; ++i) {
    const Number gap = magnitude(d[i]) - ha[i] -
                       (shadow[i][0] * hb[0] + shadow[i][1] * hb[1] + shadow[i][2] * hb[2]);
    const auto more = gap > best.face_a;
    best.face_a = more ? gap : best.face_a;
    best.axis_a = more ? zero + double(i) : best.axis_a;
  }
  if constexpr (Stop)
    if (best.face_a > margin) return best;
  for (int j = 0; j < 3; ++j) {
    const Number gap = magnitude(c[0][j] * d[0] + c[1][j] * d[1] + c[2][j] * d[2]) - hb[j] -
                       (shadow[0][j] * ha[0] + shadow[1][j] * ha[1] + shadow[2][j] * ha[2]);
    const auto more = gap > best.face_b;
    best.face_b = more ? gap : best.face_b;
    best.axis_b = more ? zero + double(j) : best.axis_b;
  }
  if constexpr (Stop)
    if (best.face_b > margin) return best;
  // Squares are compared by products, without a root or a quotient per axis.
  Number over = zero - 1., under = zero;
  for (int i = 0; i < 3; ++i) {
    const int u = (i + 1) % 3, v = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      // e_i x b_j = (0, -b_v, b_u) in the axes i, u, v. Parallel edges give no axis of their own.
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      const Number square = c[u][j] * c[u][j] + c[v][j] * c[v][j];
      const Number gap = magnitude(c[u][j] * d[v] - c[v][j] * d[u]) -
                         (ha[u] * shadow[v][j] + ha[v] * shadow[u][j] + hb[k] * shadow[i][l] +
                          hb[l] * shadow[i][k]);
      const Number signed_square = gap * magnitude(gap);
      const Number lead = signed_square * under - over * square;
      const auto more = (square < 1e-8 ? zero : lead) > 0;
      over = more ? signed_square : over;
      under = more ? square : under;
      best.axes = more ? zero + double(3 * i + j) : best.axes;
    }
  }
  best.edge = over / under;
  return best;
}

#pragma GCC diagnostic pop

template <class Real>
struct box_axis {
  Real gap = -std::numeric_limits<Real>::infinity();
  vector3<Real> normal{0, 0, 0};  // unit, in the frame of a, from a towards b
  int i = 0, j = 0;               // a face's axis is i; of edges, a's direction is i and b's is j
};

/// The best axis of each kind for boxes that are not separated.
template <class Real>
struct box_axes {
  box_axis<Real> face_a, face_b, edge;

  box_axes(const box_pair<Real>& p, const box_gaps<Real>& gaps) {
    face_a.gap = gaps.face_a, face_a.i = static_cast<int>(gaps.axis_a);
    face_b.gap = gaps.face_b, face_b.i = static_cast<int>(gaps.axis_b);
    const int e = static_cast<int>(gaps.axes);
    edge.gap = gaps.edge < 0 ? -std::sqrt(-gaps.edge) : std::sqrt(gaps.edge);
    edge.i = e / 3, edge.j = e % 3;
    face_a.normal[face_a.i] = p.offset[face_a.i] < 0 ? -1 : 1;
    face_b.normal = column_of(p.axes, face_b.i);
    if (face_b.normal.dot(p.offset) < 0) face_b.normal = -face_b.normal;
    if (!(edge.gap > -std::numeric_limits<Real>::infinity())) return;
    const int u = (edge.i + 1) % 3, v = (edge.i + 2) % 3;
    const Real x = -p.axes(v, edge.j), y = p.axes(u, edge.j);
    Real scale = 1 / std::sqrt(x * x + y * y);
    if (x * p.offset[u] + y * p.offset[v] < 0) scale = -scale;
    edge.normal[u] = scale * x, edge.normal[v] = scale * y;
  }

  /// Whether the edge axis counts as the axis of a face: they are within 11 degrees.
  [[nodiscard]] bool edge_along(const box_axis<Real>& face) const {
    return edge.normal.dot(face.normal) > Real(0.98);
  }
  [[nodiscard]] Real best() const { return std::max({face_a.gap, face_b.gap, edge.gap}); }
};

}  // namespace talus::detail
