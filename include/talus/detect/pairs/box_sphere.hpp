#pragma once
// A box and a sphere: one contact at the point of the box nearest to the centre. Reads no
// orientation of the sphere.
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/shape/box.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. A centre inside the box leaves by
/// the nearest face (of equally near ones by the first axis).
template <class Sink, class Real = real>
void collide(const box& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  using vector = vector3<Real>;  // dependent: worlds without boxes do not compile it
  const vector h = a.half();
  const vector centre = pa.to_body(pb.position);
  const vector nearest = centre.cwiseMax(-h).cwiseMin(h);
  const vector out = centre - nearest;
  const real reach = b.radius + margin;
  const Real squared = out.squaredNorm();
  if (!(squared <= reach * reach)) return;

  vector normal;  // of the box, outwards, in its frame
  Real distance;  // of the sphere's centre from the surface, negative inside
  if (squared > real(1e-200)) {
    distance = std::sqrt(squared);
    normal = out * (1 / distance);
  } else {
    const vector depth = h - centre.cwiseAbs();
    int axis = 0;
    if (depth[1] < depth[axis]) axis = 1;
    if (depth[2] < depth[axis]) axis = 2;
    normal.setZero();
    normal[axis] = centre[axis] < 0 ? -1 : 1;
    distance = -depth[axis];
  }
  const vector up = pa.orientation * normal;
  const Real gap = distance - b.radius;
  sink(contact_geometry{-up, pb.position - up * (b.radius + Real(0.5) * gap), gap, 0});
}

}  // namespace talus
