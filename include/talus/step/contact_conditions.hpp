#pragma once
// The conditions of the contact law at a new contact point: target velocity, correction, friction.
#include <algorithm>

#include "talus/body/material.hpp"
#include "talus/constraint/rebound.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"

namespace talus::detail {

/// The conditions of the contact law at a new contact point. `u` is the velocity of a relative to b
/// at the point before the step, `gap` the distance of the surfaces.
struct contact_conditions {
  real target_velocity = 0, correction_rate = 0, friction = 0;
  real restitution = 0;  ///< of an impact that strikes the contact in this step
  real limit = 0;        ///< the target velocity that follows from the gap
  real slowest = 0;      ///< see slowest_impact()
};

/// The normal velocity below which a contact is an impact: surfaces overlap after the step, and the
/// rebound is faster than bodies at rest. Those gain by the acceleration `pull` in this step
/// besides.
[[nodiscard]] inline real slowest_impact(real limit, real restitution, real pull, real dt) {
  return restitution > 0 ? std::min(limit, -3 * pull * dt / restitution) : limit;
}

/// The part of the conditions that follows from the gap alone, of one contact or of several. Up to
/// a gap of `held` surfaces are in resting contact.
template <class Pack>
struct gap_conditions {
  Pack target_velocity, correction_rate;
};
template <class Law, class Pack>
[[nodiscard]] [[gnu::always_inline]] inline gap_conditions<Pack> conditions_of_gap(
    const Pack& gap, const Pack& held, real dt, real correction) {
  const Pack zero = every_lane<Pack>(0), rate = -gap / every_lane<Pack>(dt);
  const auto rests = gap <= held;
  gap_conditions<Pack> c{rests ? zero : rate, zero};
  if constexpr (Law::correction)
    c.correction_rate = rests ? every_lane<Pack>(-correction) * gap / every_lane<Pack>(dt) : rate;
  return c;
}
/// The gap up to which an acceleration of `pull` holds surfaces together.
template <class Law, class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack held_gap(const Pack& pull, real dt) {
  if constexpr (Law::correction)
    return pull * dt * dt;
  else
    return (void)pull, (void)dt, every_lane<Pack>(0);
}

/// The velocity that iterations leave to a sticking body: a millionth of its size in a step. (If
/// other bodies press, the bodies themselves may have neither gravity nor forces.)
[[nodiscard]] inline real creep(real radius, real dt) { return 1e-6 * radius / dt; }

/// The velocity that a contact leaves to surfaces that pass each other though the gap along the
/// normal closes: that of their free motion, un before the accelerations of up to `pull`. So the
/// contact exerts nothing, unless something else in this step drives the bodies together.
[[nodiscard]] inline real passing_velocity(real gap, real un, real pull, real dt) {
  return std::min(-gap / dt, un + real(1e-9) * std::min(un, real(0)) - 2 * pull * dt);
}

/// - Separated surfaces may approach until they touch: u_n >= -gap/dt.
/// - Gaps that gravity would close within a step count as closed: surfaces hold there, u_n >= 0,
///   and the correction draws loaded ones together. (If bodies fell into such gaps, positions would
///   act on velocities, and stacks would sway: truncated iterations answer only a part c < 1 of a
///   velocity that converges slowly, and with warm starts the motion dv = y, dy = -c (v + y +
///   gap/dt) is unstable unless c is nearly 1.)
/// - A part of an overlap, or of a gap that is held, is corrected; other gaps may close.
/// - An impact faster than the gain by gravity in two steps, and due within this step, rebounds
///   with -e u_n (Newton), see rebound(); a slower one is resting contact, which must not jitter.
///   Without rebound, e = 0, the surfaces still meet. A solver with substeps (`Divided`) finds the
///   time of impact itself, and takes -e u_n.
/// - Sliding faster than the gain by gravity in a step, and than `creep`, has the dynamic
///   coefficient, else the static.
/// - With restitution, an impact elsewhere may drive surfaces together within the step that do not
///   rebound yet, or not any more; see constraint/impact_terms.hpp. (Solvers with substeps find
///   such impacts in one of these.)
/// `gravity` is the acceleration of the bodies without contacts; fall() is the part of it by which
/// the surfaces approach.
template <class Law, bool Divided, class Fall>
[[nodiscard]] contact_conditions conditions_of(const pair_material& pair, const vec3& normal,
                                               const vec3& u, real gap, real dt, real gravity,
                                               Fall&& fall, real creep, real correction) {
  contact_conditions c;
  const real un = normal.dot(u);
  const auto by_gap = conditions_of_gap<Law, real>(gap, held_gap<Law>(gravity, dt), dt, correction);
  c.target_velocity = by_gap.target_velocity, c.correction_rate = by_gap.correction_rate;
  if constexpr (Law::restitution)
    if (pair.restitution > 0 && un < -2 * gravity * dt)
      if (const real a = fall(); gap + (un - std::max(a, real{0}) * dt) * dt <= 0)
        c.target_velocity =
            std::max(c.target_velocity,
                     Divided ? -pair.restitution * un : rebound(pair.restitution, un, gap, dt, a));
  // Without correction, an overlap that a strike leaves would stay.
  if constexpr (Law::restitution && Law::correction && !Divided) {
    c.restitution = pair.restitution, c.limit = by_gap.target_velocity;
    c.slowest = slowest_impact(c.limit, c.restitution, gravity, dt);
  }
  if constexpr (Law::friction) {
    c.friction = pair.friction;
    if (pair.dynamic_friction < pair.friction) {
      const real sliding = (u - un * normal).norm();
      if (sliding > gravity * dt + creep) c.friction = pair.dynamic_friction;
    }
  }
  return c;
}

/// With the midpoint, impacts reflect velocities that have half of the acceleration `fall` of the
/// step: with e = 1 they keep the energy to round-off, in any order. Half of the motion is still to
/// come. Returns that half of the velocity.
inline real reflect_in_the_middle(contact_conditions& c, real fall, real dt) {
  if (c.limit < 0) {
    if (c.target_velocity == c.limit) c.target_velocity *= 2;
    c.limit *= 2, c.slowest = std::min(c.slowest, c.limit);
  }
  const real half = real(0.5) * fall * dt;
  c.target_velocity += half, c.limit += half, c.slowest += half;
  return half;
}

/// Without loads, surfaces that part have a gap, however small, when an impact elsewhere drives
/// them together: their limit is negative. (Under loads the last strikes would leave overlaps.)
inline void let_part(contact_conditions& c, real un) {
  constexpr real round_off = 1e-12;
  if (c.restitution > 0 && un > 0) c.target_velocity = c.limit = std::min(c.limit, -round_off * un);
}

}  // namespace talus::detail
