#pragma once
// A cylinder and a sphere: one contact at the point of the cylinder nearest to the centre.
// Reads no orientation of the sphere.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/shape/cylinder.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. A centre inside the cylinder
/// leaves by the nearest face.
template <class Sink, class Real = real>
void collide(const cylinder& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  using vector = vector3<Real>;
  const Real half = a.length / 2, reach = b.radius + margin;
  const vector centre = pa.to_body(pb.position);
  const Real from_axis = portable::hypot(centre[0], centre[1]);
  const Real beyond_side = from_axis - a.radius, beyond_end = std::abs(centre[2]) - half;
  if (!(std::max(beyond_side, beyond_end) <= reach)) return;

  const vector outwards = from_axis > Real(1e-100)
                              ? vector(centre[0] / from_axis, centre[1] / from_axis, 0)
                              : vector(1, 0, 0);
  const vector upwards(0, 0, centre[2] < 0 ? -1 : 1);
  vector normal;
  Real distance;
  if (beyond_side > 0 && beyond_end > 0) {
    distance = portable::hypot(beyond_side, beyond_end);
    normal = (beyond_side * outwards + beyond_end * upwards) / distance;
  } else if (beyond_end > beyond_side) {
    distance = beyond_end;
    normal = upwards;
  } else {
    distance = beyond_side;
    normal = outwards;
  }
  const Real gap = distance - b.radius;
  if (!(gap <= margin)) return;
  const vector up = rotated(pa.orientation, normal);
  sink(contact_geometry{-up, pb.position - up * (b.radius + Real(0.5) * gap), gap, 0});
}

}  // namespace talus
