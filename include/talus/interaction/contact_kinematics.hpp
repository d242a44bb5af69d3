#pragma once
// Arguments and results of an interaction law: the kinematics of a contact point, the force on a
// body, and the energy that the contact stores.
#include "talus/core/math.hpp"

namespace talus {

/// The relative motion of two bodies at a point where they touch or nearly touch. Velocities are
/// those of body a relative to body b.
struct contact_kinematics {
  vec3 normal{0, 0, 1};      ///< unit, from b to a
  real gap = 0;              ///< signed distance of the surfaces; an overlap is negative
  vec3 velocity{0, 0, 0};    ///< of the surfaces at the point of contact
  vec3 spin{0, 0, 0};        ///< angular velocity
  real mean_spin = 0;        ///< of the two bodies about the normal, not a difference
  real mass = 1;             ///< reduced: 1 / (1/m_a + 1/m_b)
  real radius = 1;           ///< effective: 1 / (1/R_a + 1/R_b)
  real rolling_inertia = 1;  ///< reduced moment of inertia about the point of contact
  real step = 0;             ///< the time step of the simulation; 0 if unknown
};

/// Force and moment on body a at the point of contact; the opposite acts on body b.
struct interaction_force {
  vec3 force{0, 0, 0};
  vec3 moment{0, 0, 0};
  // For features<energy_ledger>; otherwise the compiler removes their computation.
  vec3 conserved{0, 0, 0};         ///< part of the force that comes from the stored energy
  vec3 conserved_moment{0, 0, 0};  ///< part of the moment that comes from it
  real lost = 0;                   ///< energy of `stored_energy::kept` that this step dissipated
};

/// Energy that a contact returns when the bodies move back.
struct stored_energy {
  real normal = 0;  ///< a function of the gap, for the present memory; 0 at the end of the range
  real kept = 0;    ///< held in the memory, as by a spring across the normal
};

/// Inputs of friction and rolling resistance from the law with the normal force.
struct bearing {
  real pressing = 0;    ///< normal force that bounds friction, not negative
  real stiffness = 0;   ///< force per overlap, along the normal
  real tangential = 0;  ///< force per displacement, across the normal
  real damping = 0;     ///< damping ratio across the normal
};
/// The same if the stiffness across the normal grows with the circle of contact (Mindlin 1949).
struct growing_bearing : bearing {
  real contact_radius = 0;         ///< of the circle of contact
  real tangential_per_radius = 0;  ///< stiffness across the normal over that radius
};
/// The force of a law that bounds friction.
template <class Bearing>
struct bearing_force : interaction_force, Bearing {};

/// Two bodies in a head-on impact.
struct head_on_impact {
  real mass = 0;    ///< reduced mass
  real radius = 0;  ///< effective radius
  real speed = 0;   ///< relative speed
};

/// The memory of a law without memory.
struct no_memory {};

}  // namespace talus
