#pragma once
// The speed with which bodies penetrate their contact partners after the contact solution.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/residual.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Raises `speeds` of the two bodies of a contact to the speed at which each moves into the other,
/// beyond the limits of gap and restitution. The motion of the other body does not count.
template <class Contact, class State>
void add_approach(const Contact& c, const State& after, plain_vector<real>& speeds) {
  const vec3 n = c.axis();
  const real beyond = -violation(c, after).dot(n);
  if (!(beyond > 0)) return;
  const auto at = [&](std::size_t k, real sign, bool is_a) {
    const auto& body = after.bodies[k];
    if (body.inverse_mass == 0) return;
    const vec3 v = in_scalar<real>(body.v), w = in_scalar<real>(body.w);
    const vec3 u = is_a ? velocity_on_a(c, v, w) : velocity_on_b(c, v, w);
    speeds[k] = std::max(speeds[k], std::min(beyond, sign * u.dot(n)));
  };
  at(static_cast<std::size_t>(c.a), -1, true);
  if constexpr (Contact::paired) at(static_cast<std::size_t>(c.b), 1, false);
}

}  // namespace talus::detail
