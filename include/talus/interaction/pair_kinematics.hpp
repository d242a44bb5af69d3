#pragma once
// The kinematics of the contact of two bodies, of one contact or of several at once.
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Motion, mass and size of a body at its contact.
template <class Number>
struct body_at_contact {
  vectors_of<Number> v, w;
  Number inverse_mass, radius, curvature;  ///< curvature: 1 / radius
  vectors_of<Number> arm;                  ///< from its centre to the point of contact
};

/// The kinematics of the contact of two bodies that both move.
template <class Number>
[[nodiscard, gnu::always_inline]] inline contact_kinematics_of<Number> kinematics_of_pair(
    const vectors_of<Number>& normal, const Number& gap, const body_at_contact<Number>& a,
    const body_at_contact<Number>& b, real dt) {
  const auto half = real(0.5);
  contact_kinematics_of<Number> t;
  t.normal = normal, t.gap = gap;
  t.velocity = a.v + crossed(a.w, a.arm);
  t.velocity -= b.v + crossed(b.w, b.arm);
  t.spin = a.w - b.w;
  t.mean_spin = half * dot(normal, a.w) + half * dot(normal, b.w);
  const Number rolling =
      a.inverse_mass * a.curvature * a.curvature + b.inverse_mass / Number(b.radius * b.radius);
  t.mass = real(1) / Number(a.inverse_mass + b.inverse_mass);
  t.radius = real(1) / Number(a.curvature + b.curvature);
  t.step = dt;
  t.rolling_inertia = real(1.4) / rolling;  // of solid spheres about the point of contact
  return t;
}

#pragma GCC diagnostic pop

}  // namespace talus::detail
