#pragma once
// Coulomb friction between soft bodies: a spring and a dashpot across the normal.
#include <type_traits>
#include <utility>

#include "talus/body/material.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// A vector of the plane of contact carried along from the last step: rotated into the present
/// plane and with the two bodies about the normal, its length kept (Luding 2008, "Cohesive,
/// frictional powders", section 2.4).
template <class Vector>
[[nodiscard, gnu::always_inline]] inline Vector carried_along(
    const Vector& old, const Vector& normal, const typename number_in<Vector>::type& turn) {
  using number = typename number_in<Vector>::type;
  const number square = dot(old, old);
  const auto none = square == real(0);
  if (all_lanes(none)) return old;
  Vector now = old - dot(normal, old) * normal;
  now += turn * crossed(normal, now);
  const number left = dot(now, now);
  return choose(none, old,
                choose(left > real(0), Vector(square_root(number(square / left)) * now),
                       every_lane_of<number>(0, 0, 0)));
}

/// The memory of a contact with friction from step to step.
template <class Number>
struct tangential_memory_of {
  vectors_of<Number> spring = every_lane_of<Number>(0, 0, 0);  ///< across the normal, of a to b
  Number sliding{};  ///< 1 while the force stays at the cap, else 0

  template <class Memory, class F>
  static void each_column(Memory& m, F&& f) {
    bool slides = m.sliding != 0;
    f("spring", m.spring), f("sliding", slides);
    if constexpr (!std::is_const_v<Memory>) m.sliding = slides ? 1 : 0;
  }
};
using tangential_memory = tangential_memory_of<real>;
/// The memory of a contact with friction whose stiffness grows with the circle of contact.
template <class Number>
struct growing_tangential_memory_of : tangential_memory_of<Number> {
  Number contact_radius{};

  template <class Memory, class F>
  static void each_column(Memory& m, F&& f) {
    tangential_memory_of<Number>::each_column(m, f);
    f("contact_radius", m.contact_radius);
  }
};
using growing_tangential_memory = growing_tangential_memory_of<real>;

// The spring for the two kinds of bearing.

template <class Number>
[[nodiscard]] tangential_memory_of<Number> memory_on(const bearing_of<Number>&);
template <class Number>
[[nodiscard]] growing_tangential_memory_of<Number> memory_on(const growing_bearing_of<Number>&);

/// Stiffness of the spring stored in the memory.
template <class Number>
[[nodiscard, gnu::always_inline]] inline Number stiffness_in(const bearing_of<Number>& b,
                                                             const tangential_memory_of<Number>&) {
  return b.tangential;
}
template <class Number>
[[nodiscard, gnu::always_inline]] inline Number stiffness_in(
    const growing_bearing_of<Number>& b, const growing_tangential_memory_of<Number>& m) {
  return b.tangential_per_radius * m.contact_radius;
}
/// Adapts the spring to the present stiffness. While that grows the force is kept, while it shrinks
/// the force shrinks too, so that a closed path of loading never gains work (Thornton, Cummins,
/// Cleary 2013).
template <class Vector, class Number>
[[gnu::always_inline]] inline void adapt(Vector&, const bearing_of<Number>&,
                                         tangential_memory_of<Number>&) {}
template <class Vector, class Number>
[[gnu::always_inline]] inline void adapt(Vector& spring, const growing_bearing_of<Number>& b,
                                         growing_tangential_memory_of<Number>& memory) {
  spring = choose(memory.contact_radius < b.contact_radius,
                  Vector(Number(memory.contact_radius / b.contact_radius) * spring), spring);
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

  template <class Number>
  struct parameters_of {
    Number friction{}, dynamic_friction{};
    friend bool operator==(const parameters_of&, const parameters_of&) = default;
  };
  using parameters = parameters_of<real>;
  template <class Number>
  using bearing_with = typename Bearing::template with<Number>;
  template <class Number>
  using memory_of = decltype(memory_on(std::declval<bearing_with<Number>>()));
  using memory = memory_of<real>;

  [[nodiscard]] static parameters combine(const material&, const material&,
                                          const pair_material& both) {
    return {both.friction, both.dynamic_friction};
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline interaction_force_of<Number> force(
      const contact_kinematics_of<Number>& c, const std::type_identity_t<bearing_with<Number>>& b,
      const std::type_identity_t<parameters_of<Number>>& p, real dt,
      std::type_identity_t<memory_of<Number>>& memory) {
    using vector = vectors_of<Number>;
    interaction_force_of<Number> f;
    const Number before = stored(c, b, p, memory);
    const vector ut = c.velocity - dot(c.normal, c.velocity) * c.normal;
    const Number k = b.tangential;
    vector spring = carried_along(memory.spring, c.normal, c.mean_spin * dt);
    adapt(spring, b, memory);
    f.lost = before - real(0.5) * k * dot(spring, spring);
    spring += every_lane<Number>(dt) * ut;
    const vector trial = spring;
    const Number damping = real(2) * smaller(b.damping, every_lane<Number>(1)) *
                           square_root(Number(real(2.0 / 7) * c.mass * k));
    f.force = -k * spring - damping * ut;
    Number limit = choose(memory.sliding != real(0), p.dynamic_friction, p.friction) * b.pressing;
    const Number square = dot(f.force, f.force);
    const auto slides = square > limit * limit;
    memory.sliding = choose(slides, every_lane<Number>(1), Number{});
    if (any_lane(slides)) {
      limit = p.dynamic_friction * b.pressing;
      f.force = choose(slides, vector(Number(limit / square_root(square)) * f.force), f.force);
      const Number stretched = k * square_root(dot(spring, spring));
      spring = choose(both(slides, stretched > limit), vector(Number(limit / stretched) * spring),
                      spring);
    }
    memory.spring = spring;
    f.lost += k * dot(spring, vector(trial - spring));  // the remaining force times the slip
    f.conserved = -k * spring;
    return f;
  }
  template <class Number>
  [[nodiscard, gnu::always_inline]] static inline Number stored(
      const contact_kinematics_of<Number>&, const std::type_identity_t<bearing_with<Number>>& b,
      const std::type_identity_t<parameters_of<Number>>&,
      const std::type_identity_t<memory_of<Number>>& memory) {
    return real(0.5) * stiffness_in(b, memory) * dot(memory.spring, memory.spring);
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
