#pragma once
// A half-space and a sphere: one contact below the centre. Reads no orientation.
#include "talus/contact/contact_geometry.hpp"
#include "talus/shape/plane.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. The plane's pose is ignored.
template <class Sink>
void collide(const plane& a, const pose&, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  const vec3 up = a.unit_normal();
  const real gap = up.dot(pb.position) - a.offset - b.radius;
  if (!(gap <= margin)) return;
  sink(contact_geometry{-up, pb.position - up * (b.radius + real(0.5) * gap), gap, 0});
}

}  // namespace talus
