#pragma once
// The time of impact of two bodies in free flight by conservative advancement. The motion of a body
// is given by place(t) of its centre, speed(t), at(t) its pose, acceleration and spin. A motion
// with a member `bounded` gives a bound of its acceleration, whose direction has no meaning.
#include <algorithm>
#include <cmath>
#include <limits>

#include "talus/detect/collide_pair.hpp"

namespace talus::detail {

inline constexpr real never = std::numeric_limits<real>::infinity();

/// A lower bound of the time, from `from` to `to`, at which the balls of radii a and b around two
/// bodies touch; `never` if they do not.
template <class FlightA, class FlightB>
[[nodiscard]] real balls_meet(const FlightA& a, real radius_a, const FlightB& b, real radius_b,
                              real from, real to) {
  const vec3 acceleration = a.acceleration - b.acceleration;
  const vec3 start = a.place(from) - b.place(from), end = a.place(to) - b.place(to);
  // At most as far from the chord as the sag of the parabola.
  const real span = to - from, sag = acceleration.norm() * span * span / 8;
  const real reach = radius_a + radius_b + sag;
  const vec3 way = end - start;
  const real c = start.squaredNorm() - reach * reach, b_half = start.dot(way);
  if (c <= 0) return from;
  if (b_half >= 0) return never;
  const real square = way.squaredNorm(), root = b_half * b_half - square * c;
  if (root < 0) return never;
  const real part = c / (std::sqrt(root) - b_half);  // the smaller solution, without cancellation
  return part <= 1 ? from + part * span : never;
}

/// Parameters of the search besides the motions.
struct impact_search {
  real from = 0, to = 0;  ///< times
  real touch = 0;         ///< gap that counts as an impact (length, positive)
  /// Bodies nearer than this at `from` are in contact. They have no new impact unless they are
  /// apart and approach faster than `rest`, or would close by more than `plunge` until `to`.
  real zone = 0, rest = 0, plunge = 0;
  bool at_once = false;  ///< also bodies that touch at `from` have one if they approach that fast
};

/// The time at which two bodies come within a gap of `touch`; `never` if they do not. It advances
/// by the gap over a bound of the closing speed (Mirtich 1996), so never beyond the impact. If the
/// bodies pass so closely that this does not converge, the time is too early, not too late.
template <class A, class FlightA, class B, class FlightB>
[[nodiscard]] real time_of_impact(const A& a, const FlightA& fa, const B& b, const FlightB& fb,
                                  const impact_search& s) {
  // For a body of several pieces, the nearest piece gives no bound for the others.
  constexpr bool convex = !requires { a.parts(); }
  &&!requires { b.parts(); };
  constexpr int most = 100;

  real t = s.from, turning = 0;
  if constexpr (!A::isotropic) turning += fa.spin.norm() * a.bounding_radius();
  if constexpr (B::finite) {
    if constexpr (!B::isotropic) turning += fb.spin.norm() * b.bounding_radius();
    t = balls_meet(fa, a.bounding_radius(), fb, b.bounding_radius(), s.from, s.to);
    if (t == never) return never;
  }
  const bool at_start = t == s.from;
  constexpr bool bounded = requires { fa.bounded; }
  || requires { fb.bounded; };
  const vec3 acceleration = fa.acceleration - fb.acceleration;
  const real pull = acceleration.norm();
  for (int k = 0; k < most; ++k) {
    const pose pa = fa.at(t), pb = fb.at(t);
    real gap = never;
    vec3 normal{0, 0, 0};
    real margin = 0;
    if constexpr (B::finite)
      margin = (pa.position - pb.position).norm();
    else
      margin = std::max(real{0}, b.distance(pa.position));
    collide_pair(a, pa, b, pb, margin, [&](const contact_geometry& g) {
      if (g.gap < gap) gap = g.gap, normal = g.normal;
    });
    const vec3 v = fa.speed(t) - fb.speed(t);
    const bool known = convex && gap < never;
    const real faster = known && !bounded ? std::max(real(0), -normal.dot(acceleration)) : pull;
    const real closing = (known ? -normal.dot(v) : v.norm()) + faster * (s.to - t) + turning;
    gap = std::min(gap, margin);
    if (k == 0 && at_start && gap <= s.zone &&
        !((gap > s.touch || s.at_once) && -normal.dot(v) > s.rest))
      return closing * (s.to - t) > s.plunge + std::max(real{0}, gap) ? t : never;
    if (gap <= s.touch) return t;
    if (closing <= 0) return never;
    t += (gap - real(0.5) * s.touch) / closing;
    if (!(t <= s.to)) return never;
  }
  return t;
}

}  // namespace talus::detail
