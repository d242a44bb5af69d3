#pragma once
// Contacts that an impact elsewhere drives together within the step: they are released from their
// limit, and struck one by one when the others are solved.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// The velocity at a contact that a unit impulse along its normal causes, with undivided masses.
template <class Contact, class State>
[[nodiscard]] real normal_mobility_at(const Contact& c, const State& s) {
  const vec3 n = c.axis();
  const auto of = [&](std::size_t k, const vec3& lever) {
    const vec3 moment = lever.cross(n);
    const vec3 spin = s.has_tensor(k) ? vec3(s.tensor(k) * moment)
                                      : vec3(real(s.bodies[k].inverse_inertia) * moment);
    return real(s.bodies[k].inverse_mass) + moment.dot(spin);
  };
  real sum = of(static_cast<std::size_t>(c.a), c.lever_a());
  if constexpr (Contact::paired) sum += of(static_cast<std::size_t>(c.b), c.lever_b());
  return sum;
}

/// The normal velocity below which surfaces approach faster than bodies that rest: those that are
/// no impact gain by gravity in this step besides.
template <class State>
[[nodiscard]] real resting_approach(const State& s) {
  return -3 * s.fall.norm();
}

/// Releases a contact with a gap that has restitution, and that other impulses of this step drive
/// together faster than bodies that rest. (Its limit -gap/dt would stop the surfaces without
/// rebound.) The limit returns if they turn out to approach slowly: what pressed them together was
/// a load.
template <class Contact, class State>
void release_if_struck(Contact& c, State& s) {
  if (!(c.restitution > 0) || !(c.limit < 0) || c.target_velocity > c.limit) return;
  const vec3 n = c.axis();
  const real approach = n.dot(c.relative_velocity(s)), rest = resting_approach(s);
  if (c.target_velocity < c.limit) {
    if (approach >= rest) c.target_velocity = c.limit;
    return;
  }
  const real own = normal_mobility_at(c, s) * impulse_in_parts(c).normal.dot(n);
  if (approach - own >= std::min(real(c.limit), rest)) return;
  c.target_velocity += static_cast<decltype(c.target_velocity)>(8 * (approach - own));
  s.struck = true;
}

/// Whether contacts are released before iteration `k`: when others have acted, and once more.
[[nodiscard]] inline bool releases_in(int k) { return k == 1 || k == 4; }

/// The least normal velocity of a contact with which its surfaces do not overlap after the step.
template <class Contact>
[[nodiscard]] real limit_of(const Contact& c) {
  return c.restitution > 0 ? real(c.limit) : std::min(real(c.target_velocity), real{0});
}

/// A contact whose surfaces would overlap after the step, by more than round-off, is solved as an
/// impact of its two bodies alone, with all impulses of before held: one that rebounds by Newton's
/// law if they approach faster than bodies that rest. Where friction would make that add energy
/// (Kane and Levinson 1985), it acts without friction. Returns the change of its impulse, which is
/// applied to the bodies.
template <class Contact, class State>
[[nodiscard]] typename Contact::change strike(Contact& c, State& s) {
  const auto held = c.impulse_in_frame();
  const vec3 n = c.axis(), before = c.relative_velocity(s);
  const real un = n.dot(before), limit = limit_of(c);
  const bool rebounds = un < resting_approach(s);
  if (rebounds) s.struck = true;
  Contact alone = c;
  alone.set(c.since(held));
  alone.target_velocity = static_cast<decltype(c.target_velocity)>(
      rebounds ? std::max(limit, -real(c.restitution) * un) : limit);
  alone.prepare(s, 1, 1);
  auto change = alone.relax(s);
  alone.apply(s, change);
  if constexpr (Contact::rows == 3) {
    const vec3 p = impulse_on_a(alone), after = alone.relative_velocity(s);
    if (p.dot(before + after) > real(1e-12) * std::abs(p.dot(before))) {
      alone.set(c.since(held));
      alone.apply(s, alone.since(change));
      alone.friction = 0;
      change = alone.relax(s);
      alone.apply(s, change);
    }
  }
  c.set(held + change);
  c.target_velocity = alone.target_velocity;
  return change;
}
/// Whether it is to be struck: by more than round-off, and more than sweeps leave over at rest.
template <class Contact, class State>
[[nodiscard]] bool overlaps_after(const Contact& c, const State& s) {
  if (!s.still.empty()) {
    if (s.still[static_cast<std::size_t>(c.a)]) return false;
    if constexpr (Contact::paired)
      if (s.still[static_cast<std::size_t>(c.b)]) return false;
  }
  const vec3 n = c.axis();
  real size = std::abs(n.dot(v_of(s.bodies[static_cast<std::size_t>(c.a)])));
  if constexpr (Contact::paired)
    size += std::abs(n.dot(v_of(s.bodies[static_cast<std::size_t>(c.b)])));
  const real round_off = 16 * real(std::numeric_limits<typename State::number>::epsilon()) * size;
  return n.dot(c.relative_velocity(s)) <
         limit_of(c) - std::max(round_off, real(0.25) * s.fall.norm());
}

}  // namespace talus::detail
