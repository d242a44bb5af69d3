#pragma once
// Contacts that an impact elsewhere may drive together within the step: they are released.
#include <algorithm>
#include <utility>

#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// The velocity at a contact that a unit impulse along its normal causes, with undivided masses.
template <class Contact, class State>
[[nodiscard]] real normal_mobility_at(const Contact& c, const State& s) {
  const auto of = [&](std::size_t k, const vec3& lever) {
    const vec3 moment = lever.cross(vec3(c.axis()));
    const vec3 spin = s.has_tensor(k) ? vec3(s.tensor(k) * moment)
                                      : vec3(real(s.bodies[k].inverse_inertia) * moment);
    return real(s.bodies[k].inverse_mass) + moment.dot(spin);
  };
  real sum = of(static_cast<std::size_t>(c.a), c.lever_a());
  if constexpr (Contact::paired) sum += of(static_cast<std::size_t>(c.b), c.lever_b());
  return sum;
}

/// Lets the surfaces of a contact meet that does not rebound yet, has restitution, and is driven
/// together by other impulses of this step, faster than bodies that rest: the next step finds them
/// there, approaching, and makes them rebound. (With its limit -gap/dt the contact would stop them
/// without rebound.) `c.released` is the target velocity that lets surfaces enter each other; while
/// a contact is released, it is the limit, which returns if they turn out to approach slowly: what
/// pressed them together was a load.
template <class Contact, class State>
void release_if_struck(Contact& c, const State& s) {
  if (c.released == 0) return;
  const vec3 n = c.axis();
  const real approach = n.dot(c.relative_velocity(s)), rest = -2 * s.fall.norm();
  if (c.target_velocity < c.released) {
    if (approach >= rest) std::swap(c.released, c.target_velocity);
    return;
  }
  const real own = normal_mobility_at(c, s) * impulse_in_parts(c).normal.dot(n);
  if (approach - own < std::min(real(c.target_velocity), rest))
    std::swap(c.released, c.target_velocity);
}

/// Whether struck contacts are released before iteration `k`: a few times, when others have acted.
[[nodiscard]] inline bool releases_in(int k) { return k > 0 && (k & (k - 1)) == 0; }

}  // namespace talus::detail
