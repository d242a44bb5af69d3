#pragma once
// The force of one soft contact, from overlap, velocities and what it remembers.
#include <algorithm>
#include <cmath>

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
};

/// On body a; the opposite acts on b.
struct soft_force {
  vec3 force;            ///< at the point of contact
  vec3 moment{0, 0, 0};  ///< against rolling
};

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
template <class Law>
[[nodiscard]] vec3 tangential_force(const soft_touch& t, const soft_pair& pair, real normal_force,
                                    real contact_radius, real dt, typename Law::memory& memory) {
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
  spring += dt * ut;
  const real damping = 2 * pair.damping * std::sqrt(2.0 / 7 * t.mass * k);
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
  return force;
}

/// Rolling (not twisting): spring of stiffness 2.25 K (mu_r R)^2 and dashpot, the sum of which
/// yields at mu_r R f_n (Ai et al. 2011, model C; there the dashpot is free until the spring
/// yields).
template <class Law>
[[nodiscard]] vec3 rolling_moment(const soft_touch& t, const soft_pair& pair, real normal_force,
                                  real stiffness, real dt, typename Law::memory& memory) {
  if (pair.rolling_friction == 0) return {0, 0, 0};
  const real arm = pair.rolling_friction * t.radius, k = 2.25 * stiffness * arm * arm;
  const vec3 rate = t.spin - t.normal.dot(t.spin) * t.normal;
  vec3 turn = carried_along(memory.turn, t.normal, t.mean_spin * dt) + dt * rate;
  const real limit = arm * normal_force, bent = k * turn.norm();
  vec3 moment = -k * turn - (2 * rolling_damping * std::sqrt(t.rolling_inertia * k)) * rate;
  const real square = moment.squaredNorm();
  if (square > limit * limit) moment *= limit / std::sqrt(square);
  if (bent > limit) turn *= limit / bent;
  memory.turn = turn;
  return moment;
}

/// The force of a contact; `memory` is brought forward by `dt`.
template <class Law>
[[nodiscard]] soft_force force_of(const soft_touch& t, const soft_pair& pair, real dt,
                                  typename Law::memory& memory) {
  real contact_radius = 0, stiffness = pair.stiffness, critical = 2;
  if constexpr (Law::hertz) {
    contact_radius = std::sqrt(t.radius * t.overlap);
    stiffness *= contact_radius;
    critical = 2.2360679774997896964;  // sqrt(5), see damping_of_restitution()
  }
  const real damping = critical * pair.damping * std::sqrt(t.mass * stiffness);
  const real normal_force = std::max(real{0}, stiffness * t.overlap - damping * t.normal.dot(t.u));
  soft_force f{normal_force * t.normal};
  if constexpr (Law::friction)
    f.force += tangential_force<Law>(t, pair, normal_force, contact_radius, dt, memory);
  if constexpr (Law::rolling)
    f.moment = rolling_moment<Law>(t, pair, normal_force, stiffness, dt, memory);
  return f;
}

}  // namespace talus::detail
