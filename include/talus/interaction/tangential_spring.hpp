#pragma once
// Coulomb friction between soft bodies: a spring and a dashpot across the normal.
#include <algorithm>
#include <cmath>
#include <utility>

#include "talus/body/material.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus::detail {

/// A vector of the plane of contact carried along from the last step: rotated into the present
/// plane and with the two bodies about the normal, its length kept (Luding 2008, "Cohesive,
/// frictional powders", section 2.4).
[[nodiscard, gnu::always_inline]] inline vec3 carried_along(const vec3& old, const vec3& normal,
                                                            real turn) {
  const real square = old.squaredNorm();
  if (square == 0) return old;
  vec3 now = old - normal.dot(old) * normal;
  now += turn * normal.cross(now);
  const real left = now.squaredNorm();
  return left > 0 ? vec3(now * std::sqrt(square / left)) : vec3(0, 0, 0);
}

/// The memory of a contact with friction from step to step.
struct tangential_memory {
  vec3 spring{0, 0, 0};  ///< elongation across the normal, of a relative to b
  bool sliding = false;

  template <class Memory, class F>
  static void each_column(Memory& m, F&& f) {
    f("spring", m.spring), f("sliding", m.sliding);
  }
};
/// The same where the stiffness grows with the circle of contact.
struct growing_tangential_memory : tangential_memory {
  real contact_radius = 0;

  template <class Memory, class F>
  static void each_column(Memory& m, F&& f) {
    tangential_memory::each_column(m, f);
    f("contact_radius", m.contact_radius);
  }
};

// The spring for the two kinds of bearing.

[[nodiscard]] tangential_memory memory_on(const bearing&);
[[nodiscard]] growing_tangential_memory memory_on(const growing_bearing&);

/// Stiffness of the spring stored in the memory.
[[nodiscard]] inline real stiffness_in(const bearing& b, const tangential_memory&) {
  return b.tangential;
}
[[nodiscard]] inline real stiffness_in(const growing_bearing& b,
                                       const growing_tangential_memory& m) {
  return b.tangential_per_radius * m.contact_radius;
}
/// Adapts the spring to the present stiffness. While that grows the force is kept, while it shrinks
/// the force shrinks too, so that a closed path of loading never gains work (Thornton, Cummins,
/// Cleary 2013).
inline void adapt(vec3&, const bearing&, tangential_memory&) {}
inline void adapt(vec3& spring, const growing_bearing& b, growing_tangential_memory& memory) {
  if (memory.contact_radius < b.contact_radius) spring *= memory.contact_radius / b.contact_radius;
  memory.contact_radius = b.contact_radius;
}

/// Resistance across the normal: a spring and a dashpot, capped at mu f_n (Cundall, Strack 1979).
/// The spring itself never exceeds the cap. The static coefficient holds until it is reached, the
/// dynamic one as long as the force stays at it.
template <class Bearing>
struct tangential_spring final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "coulomb_friction";
  static constexpr bool exerts_moment = false;

  struct parameters {
    real friction = 0, dynamic_friction = 0;
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  using memory = decltype(memory_on(std::declval<Bearing>()));

  [[nodiscard]] static parameters combine(const material&, const material&,
                                          const pair_material& both) {
    return {both.friction, both.dynamic_friction};
  }
  [[nodiscard, gnu::always_inline]] static inline interaction_force force(
      const contact_kinematics& c, const Bearing& b, const parameters& p, real dt, memory& memory) {
    interaction_force f;
    const real before = stored(c, b, p, memory);
    const vec3 ut = c.velocity - c.normal.dot(c.velocity) * c.normal;
    const real k = b.tangential;
    vec3 spring = carried_along(memory.spring, c.normal, c.mean_spin * dt);
    adapt(spring, b, memory);
    f.lost = before - real(0.5) * k * spring.squaredNorm();
    spring += dt * ut;
    const vec3 trial = spring;
    const real damping = 2 * std::min(real{1}, b.damping) * std::sqrt(2.0 / 7 * c.mass * k);
    f.force = -k * spring - damping * ut;
    real limit = (memory.sliding ? p.dynamic_friction : p.friction) * b.pressing;
    const real square = f.force.squaredNorm();
    memory.sliding = square > limit * limit;
    if (memory.sliding) {
      limit = p.dynamic_friction * b.pressing;
      f.force *= limit / std::sqrt(square);
      const real stretched = k * spring.norm();
      if (stretched > limit) spring *= limit / stretched;
    }
    memory.spring = spring;
    f.lost += k * spring.dot(trial - spring);  // the remaining force times the slip
    f.conserved = -k * spring;
    return f;
  }
  [[nodiscard, gnu::always_inline]] static inline real stored(const contact_kinematics&,
                                                              const Bearing& b, const parameters&,
                                                              const memory& memory) {
    return real(0.5) * stiffness_in(b, memory) * memory.spring.squaredNorm();
  }
};

}  // namespace talus::detail
