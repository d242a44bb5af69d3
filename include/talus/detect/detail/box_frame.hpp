#pragma once
// Two boxes in the frame of one of them, and the names of their corners, edges and faces.
// Everything in the box_*.hpp files is a template of the scalar, so that worlds without boxes do
// not compile it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Two flat sides in one plane that overlap in a strip narrower than this part of the thinner body,
/// or miss each other by less, carry nothing: an edge of each lies along the other, as of diagonal
/// neighbours in a wall. Which of several faces separates such bodies best is a matter of
/// round-off.
template <class Real>
inline constexpr Real flush_strip = Real(1e-4);

/// A corner that is less than this part of the thinner body outside of an outline counts as inside,
/// so that bodies of one size stacked flush keep their own corners in spite of round-off. A body
/// that passes an edge in a larger distance does not touch it.
template <class Real>
inline constexpr Real outline_slack = Real(1e-6);

/// A corner, edge or face of a box: for each axis that it fixes, the side. Bit 2i is the negative
/// side of axis i, bit 2i + 1 the positive one; a corner has three bits, an edge two, a face one.
/// The common part of two of them is their bitwise and.
using box_part = std::uint32_t;

inline box_part side(int axis, bool positive) { return box_part{1} << (2 * axis + positive); }

inline box_part corner_part(unsigned corner) {
  return side(0, corner & 1u) | side(1, corner & 2u) | side(2, corner & 4u);
}
/// The position of a corner, with bits as in corner_part.
template <class Real>
vector3<Real> corner_of(const vector3<Real>& half, unsigned corner) {
  return {corner & 1u ? half[0] : -half[0], corner & 2u ? half[1] : -half[1],
          corner & 4u ? half[2] : -half[2]};
}

/// The part of the box to which the point nearest to `p` belongs, `p` being outside.
template <class Real>
box_part nearest_part(const vector3<Real>& half, const vector3<Real>& p) {
  box_part part = 0;
  for (int i = 0; i < 3; ++i)
    if (std::abs(p[i]) > half[i]) part |= side(i, p[i] > 0);
  return part;
}

template <class Real>
[[nodiscard]] vector3<Real> column_of(const matrix3<Real>& m, int j) {
  return {m(0, j), m(1, j), m(2, j)};
}

/// Boxes a and b in the frame of a: b's axes are the columns of `axes`, its centre is `offset`.
template <class Real>
struct box_pair {
  vector3<Real> ha, hb;  // half edges
  matrix3<Real> axes;
  vector3<Real> offset;

  /// The pair with the roles of the two boxes exchanged.
  [[nodiscard]] box_pair swapped() const {
    return {hb, ha, axes.transpose(), -(axes.transpose() * offset)};
  }
  [[nodiscard]] vector3<Real> from_b(const vector3<Real>& p) const { return offset + axes * p; }
  [[nodiscard]] vector3<Real> to_b(const vector3<Real>& p) const {
    return axes.transpose() * (p - offset);
  }
  [[nodiscard]] Real smallest() const { return std::min(ha.minCoeff(), hb.minCoeff()); }
};

/// One contact of two boxes, in the frame of a, its normal from a towards b.
template <class Real>
struct box_contact {
  vector3<Real> normal, point;
  Real gap = 0;
  box_part a = 0, b = 0;

  [[nodiscard]] std::uint32_t feature() const { return a | b << 6; }
};

}  // namespace talus::detail
