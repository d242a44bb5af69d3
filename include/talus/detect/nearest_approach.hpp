#pragma once
// Whether two bodies touch on their paths, or pass each other. The motion of a body is given as in
// time_of_impact.hpp.
#include <algorithm>
#include <cmath>

#include "talus/detect/collide_pair.hpp"
#include "talus/detect/time_of_impact.hpp"

namespace talus::detail {

/// Whether two points, `apart` at first, come within a distance of `reach` on the straight way
/// `way` of the first relative to the second.
[[nodiscard]] inline bool points_come_near(const vec3& apart, const vec3& way, real reach) {
  const real square = way.squaredNorm();
  const real part = square > 0 ? std::clamp(-apart.dot(way) / square, real(0), real(1)) : real(0);
  return vec3(apart + part * way).squaredNorm() <= reach * reach;
}

/// Whether two bodies come within a gap of `touch` from time 0 to `to`, by conservative advancement
/// (Mirtich 1996). If the smallest gap is between half of it and `touch`, the result may be either;
/// if there is no answer after 1000 advances, it is yes.
template <class A, class FlightA, class B, class FlightB>
[[nodiscard]] bool come_near(const A& a, const FlightA& fa, const B& b, const FlightB& fb, real to,
                             real touch) {
  constexpr int most = 1000;

  real turning = 0;
  if constexpr (!A::isotropic) turning += fa.spin.norm() * a.bounding_radius();
  if constexpr (!B::isotropic) turning += fb.spin.norm() * b.bounding_radius();
  const real pull = (fa.acceleration - fb.acceleration).norm();
  bool near = false;  // at the end, as most
  collide_pair(a, fa.at(to), b, fb.at(to), touch,
               [&](const contact_geometry& g) { near = near || g.gap <= touch; });
  if (near) return true;
  real t = 0;
  for (int k = 0; k < most; ++k) {
    const vec3 v = fa.speed(t) - fb.speed(t);
    const real fastest = v.norm() + pull * (to - t) + turning;
    // Each convex piece has a normal of its own, along which it comes closer; the soonest counts.
    real gap = never, soonest = never;
    collide_pair(a, fa.at(t), b, fb.at(t), touch + fastest * (to - t),
                 [&](const contact_geometry& g) {
                   gap = std::min(gap, g.gap);
                   const real closing = -g.normal.dot(v) + pull * (to - t) + turning;
                   if (closing > 0)
                     soonest = std::min(soonest, (g.gap - real(0.5) * touch) / closing);
                 });
    if (gap <= touch) return true;
    t += soonest;
    if (!(t <= to)) return false;
  }
  return true;
}

}  // namespace talus::detail
