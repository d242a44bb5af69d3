#pragma once
// Contacts that an impact elsewhere drives together within the step: they rebound in the
// last sweeps.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "talus/constraint/contact_impact.hpp"
#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/constraint/stored_impulses.hpp"
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

/// The impulse so far is that of impacts that are over.
template <class Contact>
void hold_impulse(Contact& c) {
  const auto r = c.impulse_in_frame();
  c.held = c.held + r;
  c.set(c.since(r));
  c.target_velocity = c.limit;
}

/// Solves an impact of two bodies alone by Newton's law. Where friction would make that add energy
/// (Kane and Levinson 1985), it acts without friction.
template <class Contact, class State>
void strike(Contact& c, State& s, real approach) {
  hold_impulse(c);
  Contact alone = c;
  alone.target_velocity = static_cast<decltype(c.target_velocity)>(-c.restitution * approach);
  if constexpr (!comes_in_manifolds<Contact>) {
    alone.apply(s, alone.relax(s));
  } else {
    alone.prepare(s, 1, 1);
    const vec3 before = alone.relative_velocity(s);
    const auto d = alone.relax(s);
    alone.apply(s, d);
    const vec3 p = impulse_on_a(alone), after = alone.relative_velocity(s);
    if (p.dot(before + after) > real(1e-12) * std::abs(p.dot(before))) {
      alone.set(alone.since(d));
      alone.apply(s, alone.since(d));
      alone.friction = 0;
      alone.apply(s, alone.relax(s));
    }
  }
  c.held = c.held + alone.impulse_in_frame();
}

/// The stage of the sweep for one contact, before it is solved. If its impulse is not to be
/// changed here, since several contacts are solved simultaneously, an impact is left to these
/// sweeps.
template <bool Simultaneous = false, class Contact, class State>
void meet_impacts(Contact& c, State& s) {
  if constexpr (may_rebound<Contact>) {
    if (s.stage == impact_stage::none || !(c.restitution > 0)) return;
    const vec3 n = c.axis();
    const real approach = n.dot(c.relative_velocity(s)), least = c.slowest;
    if (s.stage == impact_stage::release) {
      if (c.target_velocity > c.limit || !(c.limit < 0)) return;
      const real other = approach - normal_mobility_at(c, s) * impulse_in_parts(c).normal.dot(n);
      if (other < least)  // further sweeps may drive the surfaces together faster
        c.target_velocity = std::min(c.target_velocity,
                                     static_cast<decltype(c.target_velocity)>(c.limit + 8 * other));
      return;
    }
    if (c.target_velocity > c.limit) hold_impulse(c);
    c.target_velocity = c.limit;
    // Contacts that carry an impulse resist a load.
    if (approach >= least || impulse_in_parts(c).normal != vec3(0, 0, 0)) return;
    if constexpr (Simultaneous)
      hold_impulse(c),
          c.target_velocity = static_cast<decltype(c.target_velocity)>(-c.restitution * approach);
    else
      strike(c, s, approach);
  }
}

/// After the sweeps: adds the impulses that are held to the others.
template <class Lists, class State>
void end_impacts(Lists& lists, State& s) {
  each_of(lists, [](auto& list) {
    if constexpr (requires { list.end_impacts(); }) list.end_impacts();
  });
  s.impacts_ended = true;
}

}  // namespace talus::detail
