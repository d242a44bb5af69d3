#pragma once
// The work of a constraint on its two bodies, that of a contact in parts: for monitors of energy
// and momentum.
#include "talus/body/jointed_body.hpp"
#include "talus/constraint/joint_in_list.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// The impulse of a contact on its body a; that on b is the opposite.
struct split_impulse {
  vec3 normal{0, 0, 0};
  vec3 tangential{0, 0, 0};
};

template <class Contact>
[[nodiscard]] split_impulse impulse_in_parts(const Contact& c) {
  split_impulse p;
  if constexpr (requires { c.r; }) {
    p.normal = c.r[0] * c.normal;
    if constexpr (Contact::rows == 3) p.tangential = c.axes().transpose() * vec3(0, c.r[1], c.r[2]);
  } else {
    p.normal = c.rn * c.axis();
    if constexpr (requires { c.rt; }) p.tangential = in_scalar<real>(c.rt);
  }
  return p;
}

/// Velocity of the contact point on body a, which moves with v and rotates with w. Its product with
/// the impulse on a is the work on that body, to round-off: it is the velocity of the solver.
template <class Contact>
[[nodiscard]] vec3 velocity_on_a(const Contact& c, const vec3& v, const vec3& w) {
  if constexpr (requires { c.r; })
    return v + w.cross(c.arm_a);
  else if constexpr (requires { c.rt; })
    return v + c.arm_a * c.axis().cross(w);
  else
    return v;
}
/// Velocity of the contact point on body b, which moves with v and rotates with w. Its product with
/// the impulse on b is the work on that body, to round-off.
template <class Contact>
[[nodiscard]] vec3 velocity_on_b(const Contact& c, const vec3& v, const vec3& w) {
  if constexpr (requires { c.r; })
    return v + w.cross(c.arm_b);
  else if constexpr (requires { c.rt; })
    return v - c.arm_b * c.axis().cross(w);
  else
    return v;
}

/// The work of the impulse of a constraint on its body a, which moves with v and rotates with w.
template <class Constraint>
[[nodiscard]] real work_on_a(const Constraint& c, const vec3& v, const vec3& w) {
  if constexpr (is_joint<Constraint>) {
    return work_of(c.on_a(), v, w);
  } else {
    const split_impulse p = impulse_in_parts(c);
    return (p.normal + p.tangential).dot(velocity_on_a(c, v, w));
  }
}
/// The work of the impulse of a constraint on its body b, which moves with v and rotates with w.
template <class Constraint>
[[nodiscard]] real work_on_b(const Constraint& c, const vec3& v, const vec3& w) {
  if constexpr (is_joint<Constraint>) {
    return work_of(c.on_b(), v, w);
  } else {
    const split_impulse p = impulse_in_parts(c);
    return -(p.normal + p.tangential).dot(velocity_on_b(c, v, w));
  }
}
/// The impulse of a constraint on its body a.
template <class Constraint>
[[nodiscard]] vec3 impulse_on_a(const Constraint& c) {
  if constexpr (is_joint<Constraint>) {
    return c.on_a().impulse;
  } else {
    const split_impulse p = impulse_in_parts(c);
    return p.normal + p.tangential;
  }
}

}  // namespace talus::detail
