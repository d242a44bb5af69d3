#pragma once
// Two spheres: one contact on the line of centres. Reads no orientation.
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. Concentric spheres are pushed
/// apart along z.
template <class Sink>
void collide(const sphere& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  const vec3 d = pa.position - pb.position;
  const real touch = a.radius + b.radius;
  const real reach = touch + margin;
  const real squared = d.squaredNorm();
  if (!(squared <= reach * reach)) return;
  const real distance = std::sqrt(squared);
  const vec3 normal = squared > real(1e-200) ? vec3(d * (1 / distance)) : vec3(0, 0, 1);
  const real gap = distance - touch;
  sink(contact_geometry{normal, pb.position + normal * (b.radius + real(0.5) * gap), gap, 0});
}

}  // namespace talus
