#pragma once
// A half-space and a box: a contact at each near corner, at most four.
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/plane.hpp"

namespace talus {

/// Calls `sink(contact_geometry)` for the corners of the box with a gap of at most `margin`, in the
/// order of their numbers; the feature is the number of the corner (bit i: positive side of axis
/// i). Only the four corners of the face that faces the plane most can be contacts: the lowest is
/// among them, and each of the others lies above one of them.
template <class Sink, class Real = real>
void collide(const plane& a, const pose&, const box& b, const pose& pb, real margin, Sink&& sink) {
  using vector = vector3<Real>;  // dependent: worlds without boxes do not compile it
  const vector up = a.unit_normal();
  const Real height = up.dot(pb.position) - a.offset;
  const vector h = b.half();
  if (!(height - h.norm() <= margin)) return;

  const matrix3<Real> axes = pb.orientation.toRotationMatrix();
  const vector slope = axes.transpose() * up;
  const vector rise = slope.cwiseProduct(h);
  int face = 0;
  if (std::abs(slope[1]) > std::abs(slope[face])) face = 1;
  if (std::abs(slope[2]) > std::abs(slope[face])) face = 2;
  const unsigned low = slope[face] > 0 ? 0u : 1u;

  for (unsigned corner = 0; corner < 8; ++corner) {
    if ((corner >> face & 1u) != low) continue;
    const vector sign{corner & 1u ? 1. : -1., corner & 2u ? 1. : -1., corner & 4u ? 1. : -1.};
    const Real gap = height + sign.dot(rise);
    if (!(gap <= margin)) continue;
    const vector at = pb.position + axes * sign.cwiseProduct(h);
    sink(contact_geometry{-up, at - up * (Real(0.5) * gap), gap, corner});
  }
}

}  // namespace talus
