#pragma once
// The force of one soft contact, from overlap, velocities and what it remembers.
#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/response/soft_pair.hpp"

namespace talus::detail {

/// What the force of a contact follows from; velocities are those of a relative to b.
struct soft_touch {
  vec3 normal;         ///< from b to a
  real overlap = 0;    ///< > 0
  vec3 u;              ///< velocity at the point of contact
  vec3 spin;           ///< angular velocity of a relative to b
  real mean_spin = 0;  ///< of the two about the normal
  real mass = 0;       ///< reduced: 1 / (1/m_a + 1/m_b)
  real radius = 0;     ///< effective: 1 / (1/R_a + 1/R_b)
  real rolling_inertia = 0;
  real step = 0;  ///< of the time
};

/// Part of the approach that an overdamped dashpot takes away in a step at most: a step that does
/// not resolve it stays stable. (At a fifth of the critical time step it is resolved.)
inline constexpr real most_damping = 0.5;

/// On body a; the opposite acts on b.
struct soft_force {
  vec3 force;            ///< at the point of contact
  vec3 moment{0, 0, 0};  ///< against rolling
};

/// For the energy ledger: which part of a force is of the springs, which of dashpots and friction,
/// and the energy of the springs.
struct soft_parts {
  real spring = 0, dashpot = 0;  ///< along the normal
  vec3 tangential_spring{0, 0, 0}, tangential_rest{0, 0, 0};
  vec3 rolling_spring{0, 0, 0}, rolling_rest{0, 0, 0};
  real stored = 0;         ///< along the normal
  real across_before = 0;  ///< across it and of rolling, as remembered
  real across = 0;         ///< the same now
  real yielded = 0;        ///< what the latter lost otherwise than by moving bodies
};
struct no_soft_parts {};

/// Energy of the spring along the normal, of the given stiffness at this overlap.
template <class Law>
[[nodiscard]] real normal_energy(real stiffness, real overlap) {
  return (Law::hertz ? real(0.4) : real(0.5)) * stiffness * overlap * overlap;
}
/// Energy of the spring across the normal, as remembered.
template <class Law>
[[nodiscard]] real tangential_energy(const soft_pair& pair, const typename Law::memory& memory) {
  real k = pair.tangential;
  if constexpr (Law::hertz) k *= memory.contact_radius;
  return real(0.5) * k * memory.spring.squaredNorm();
}
/// Stiffness of the spring of rolling.
[[nodiscard]] inline real rolling_stiffness(const soft_touch& t, const soft_pair& pair,
                                            real stiffness) {
  const real arm = pair.rolling_friction * t.radius;
  return 2.25 * stiffness * arm * arm;
}

/// A vector of the plane of touch taken along from the last step: turned into the present plane and
/// with the two bodies about the normal, its length kept (Luding 2008, "Cohesive, frictional
/// powders", section 2.4).
[[nodiscard]] inline vec3 carried_along(const vec3& old, const vec3& normal, real turn) {
  const real square = old.squaredNorm();
  if (square == 0) return old;
  vec3 now = old - normal.dot(old) * normal;
  now += turn * normal.cross(now);
  const real left = now.squaredNorm();
  return left > 0 ? vec3(now * std::sqrt(square / left)) : vec3(0, 0, 0);
}

/// Part of critical damping that the spring of rolling has (Ai et al. 2011 take 0.3).
inline constexpr real rolling_damping = 0.3;

/// Across the normal: a spring and a dashpot, capped at mu f_n (Cundall, Strack 1979). The spring
/// itself never exceeds the cap. The static coefficient holds until it is reached, the dynamic one
/// as long as the force stays at it.
template <class Law, class Parts>
[[nodiscard]] vec3 tangential_force(const soft_touch& t, const soft_pair& pair, real normal_force,
                                    real contact_radius, real dt, typename Law::memory& memory,
                                    Parts& parts) {
  constexpr bool booked = !std::is_empty_v<Parts>;
  if constexpr (booked) parts.across_before += tangential_energy<Law>(pair, memory);
  const vec3 ut = t.u - t.normal.dot(t.u) * t.normal;
  real k = pair.tangential;
  vec3 spring = carried_along(memory.spring, t.normal, t.mean_spin * dt);
  if constexpr (Law::hertz) {
    // Stiffer with the overlap: while that grows the force is kept, while it shrinks it shrinks
    // too, so that a closed path of loading never yields work (Thornton, Cummins, Cleary 2013).
    k *= contact_radius;
    if (memory.contact_radius < contact_radius) spring *= memory.contact_radius / contact_radius;
    memory.contact_radius = contact_radius;
  }
  if constexpr (booked) parts.yielded += parts.across_before - real(0.5) * k * spring.squaredNorm();
  spring += dt * ut;
  const vec3 trial = spring;
  const real damping = 2 * std::min(real{1}, pair.damping) * std::sqrt(2.0 / 7 * t.mass * k);
  vec3 force = -k * spring - damping * ut;
  real limit = (memory.sliding ? pair.dynamic_friction : pair.friction) * normal_force;
  const real square = force.squaredNorm();
  memory.sliding = square > limit * limit;
  if (memory.sliding) {
    limit = pair.dynamic_friction * normal_force;
    force *= limit / std::sqrt(square);
    const real stretched = k * spring.norm();
    if (stretched > limit) spring *= limit / stretched;
  }
  memory.spring = spring;
  if constexpr (booked) {
    parts.across += real(0.5) * k * spring.squaredNorm();
    parts.yielded += k * spring.dot(trial - spring);  // the force that is left, over the slip
    parts.tangential_spring = -k * spring;
    parts.tangential_rest = force - parts.tangential_spring;
  }
  return force;
}

/// Rolling (not twisting): spring of stiffness 2.25 K (mu_r R)^2 and dashpot, the sum of which
/// yields at mu_r R f_n (Ai et al. 2011, model C; there the dashpot is free until the spring
/// yields).
template <class Law, class Parts>
[[nodiscard]] vec3 rolling_moment(const soft_touch& t, const soft_pair& pair, real normal_force,
                                  real stiffness, real dt, typename Law::memory& memory,
                                  Parts& parts) {
  if (pair.rolling_friction == 0) return {0, 0, 0};
  constexpr bool booked = !std::is_empty_v<Parts>;
  const real arm = pair.rolling_friction * t.radius, k = rolling_stiffness(t, pair, stiffness);
  const vec3 rate = t.spin - t.normal.dot(t.spin) * t.normal;
  if constexpr (booked) parts.across_before += real(0.5) * k * memory.turn.squaredNorm();
  vec3 turn = carried_along(memory.turn, t.normal, t.mean_spin * dt) + dt * rate;
  const vec3 trial = turn;
  const real limit = arm * normal_force, bent = k * turn.norm();
  vec3 moment = -k * turn - (2 * rolling_damping * std::sqrt(t.rolling_inertia * k)) * rate;
  const real square = moment.squaredNorm();
  if (square > limit * limit) moment *= limit / std::sqrt(square);
  if (bent > limit) turn *= limit / bent;
  memory.turn = turn;
  if constexpr (booked) {
    parts.across += real(0.5) * k * turn.squaredNorm();
    parts.yielded += k * turn.dot(trial - turn);
    parts.rolling_spring = -k * turn;
    parts.rolling_rest = moment - parts.rolling_spring;
  }
  return moment;
}

/// The force of a contact; `memory` is brought forward by `dt`. What `parts` has is filled.
template <class Law, class Parts>
[[nodiscard]] soft_force force_of(const soft_touch& t, const soft_pair& pair, real dt,
                                  typename Law::memory& memory, Parts& parts) {
  real contact_radius = 0, stiffness = pair.stiffness, critical = 2;
  if constexpr (Law::hertz) {
    contact_radius = std::sqrt(t.radius * t.overlap);
    stiffness *= contact_radius;
    critical = 2.2360679774997896964;  // sqrt(5), see damping_of_restitution()
  }
  real damping = critical * pair.damping * std::sqrt(t.mass * stiffness);
  if (pair.damping > 1 && t.step > 0) damping = std::min(damping, most_damping * t.mass / t.step);
  const real normal_force = std::max(real{0}, stiffness * t.overlap - damping * t.normal.dot(t.u));
  soft_force f{normal_force * t.normal};
  if constexpr (!std::is_empty_v<Parts>) {
    parts.spring = stiffness * t.overlap;
    parts.dashpot = normal_force - parts.spring;
    parts.stored = normal_energy<Law>(stiffness, t.overlap);
  }
  if constexpr (Law::friction)
    f.force += tangential_force<Law>(t, pair, normal_force, contact_radius, dt, memory, parts);
  if constexpr (Law::rolling)
    f.moment = rolling_moment<Law>(t, pair, normal_force, stiffness, dt, memory, parts);
  return f;
}

/// Energies of the springs of a contact, along the normal and across it.
template <class Law>
[[nodiscard]] std::array<real, 2> stored_energy(const soft_touch& t, const soft_pair& pair,
                                                const typename Law::memory& memory) {
  real stiffness = pair.stiffness, across = 0;
  if constexpr (Law::hertz) stiffness *= std::sqrt(t.radius * t.overlap);
  if constexpr (Law::friction) across += tangential_energy<Law>(pair, memory);
  if constexpr (Law::rolling)
    across += real(0.5) * rolling_stiffness(t, pair, stiffness) * memory.turn.squaredNorm();
  return {normal_energy<Law>(stiffness, t.overlap), across};
}

}  // namespace talus::detail
