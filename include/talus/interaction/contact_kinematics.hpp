#pragma once
// Arguments and results of an interaction law: the kinematics of a contact point, the force on a
// body, and the energy that the contact stores. Those of one contact have numbers, those of several
// contacts at once have packs (core/pack.hpp).
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus {

/// The relative motion of two bodies at a point where they touch or nearly touch. Velocities are
/// those of body a relative to body b.
template <class Number>
struct contact_kinematics_of {
  using vector = detail::vectors_of<Number>;

  vector normal = detail::every_lane_of<Number>(0, 0, 1);  ///< unit, from b to a
  Number gap{};  ///< signed distance of the surfaces; an overlap is negative
  vector velocity = detail::every_lane_of<Number>(0, 0, 0);  ///< of the surfaces at the point
  vector spin = detail::every_lane_of<Number>(0, 0, 0);      ///< angular velocity
  Number mean_spin{};  ///< of the two bodies about the normal, not a difference
  Number mass = detail::every_lane<Number>(1);    ///< reduced: 1 / (1/m_a + 1/m_b)
  Number radius = detail::every_lane<Number>(1);  ///< effective: 1 / (1/R_a + 1/R_b)
  Number rolling_inertia =
      detail::every_lane<Number>(1);  ///< reduced moment of inertia about the point of contact
  real step = 0;                      ///< the time step of the simulation; 0 if unknown
};
using contact_kinematics = contact_kinematics_of<real>;

/// Force and moment on body a at the point of contact; the opposite acts on body b.
template <class Number>
struct interaction_force_of {
  using vector = detail::vectors_of<Number>;

  vector force = detail::every_lane_of<Number>(0, 0, 0);
  vector moment = detail::every_lane_of<Number>(0, 0, 0);
  // For features<energy_ledger>; otherwise the compiler removes their computation.
  /// Part of the force that comes from the stored energy.
  vector conserved = detail::every_lane_of<Number>(0, 0, 0);
  /// Part of the moment that comes from it.
  vector conserved_moment = detail::every_lane_of<Number>(0, 0, 0);
  Number lost{};  ///< energy of `stored_energy::kept` that this step dissipated
};
using interaction_force = interaction_force_of<real>;

/// Energy that a contact returns when the bodies move back.
template <class Number>
struct stored_energy_of {
  Number normal{};  ///< a function of the gap, for the present memory; 0 at the end of the range
  Number kept{};    ///< held in the memory, as by a spring across the normal
};
using stored_energy = stored_energy_of<real>;

/// Inputs of friction and rolling resistance from the law with the normal force.
template <class Number>
struct bearing_of {
  using number = Number;
  template <class Other>
  using with = bearing_of<Other>;  ///< the same of other numbers

  Number pressing{};    ///< normal force that bounds friction, not negative
  Number stiffness{};   ///< force per overlap, along the normal
  Number tangential{};  ///< force per displacement, across the normal
  Number damping{};     ///< damping ratio across the normal
};
using bearing = bearing_of<real>;
/// Inputs of friction and rolling resistance for a law whose stiffness across the normal grows with
/// the circle of contact (Mindlin 1949).
template <class Number>
struct growing_bearing_of : bearing_of<Number> {
  template <class Other>
  using with = growing_bearing_of<Other>;

  Number contact_radius{};         ///< of the circle of contact
  Number tangential_per_radius{};  ///< stiffness across the normal over that radius
};
using growing_bearing = growing_bearing_of<real>;
/// The force of a law that bounds friction.
template <class Bearing>
struct bearing_force : interaction_force_of<typename Bearing::number>, Bearing {};

/// Two bodies in a head-on impact.
struct head_on_impact {
  real mass = 0;    ///< reduced mass
  real radius = 0;  ///< effective radius
  real speed = 0;   ///< relative speed
};

/// The memory of a law without memory.
struct no_memory {};

}  // namespace talus
