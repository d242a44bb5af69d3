#pragma once
// Keeps the momentum balance during a step: what the bodies gained, and who gave it.
#include <cmath>

#include "talus/core/portable_powers.hpp"
#include "talus/response/contact_work.hpp"
#include "talus/world/energy_ledger.hpp"
#include "talus/world/solved_velocity.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

/// The impulse that global and fixed bodies gave in the last step to those of this rank.
template <class Scenario>
[[nodiscard]] vec3 impulse_of_ground(const world_state<Scenario>& s) {
  const auto& solver = s.solver;
  compensated_sum<vec3> sum;
  s.each_contact_list([&](const auto& list) {
    list.each_acting([&](const auto& c, bool on_a, bool on_b) {
      if (!on_a || !on_b) return;  // both can move
      const auto give = [&](real sign) {
        const split_impulse p = impulse_in_parts(c);
        sum += vec3(sign * (p.normal + p.tangential));
      };
      if constexpr (std::remove_cvref_t<decltype(c)>::paired) {
        const auto b = static_cast<std::size_t>(c.b);
        if (solver.bodies[b].inverse_mass == 0 || b >= solver.first_global)
          give(1);
        else if (solver.bodies[static_cast<std::size_t>(c.a)].inverse_mass == 0)
          give(-1);
      } else {
        give(1);
      }
    });
  });
  return sum.value();
}

/// After the response, before positions move. Contacts between bodies that move give nothing in
/// sum; if the two sides of a contact across ranks gave differently, the balance would show it.
template <class Scenario>
void book_momentum(world_state<Scenario>& s) {
  momentum_record& r = s.monitors.momentum;
  r = {};
  const real lost = s.damping == 1 ? 0 : 1 - portable::pow(s.damping, s.dt);
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t k) {
    if (!store.moves(i)) return;
    const real mass = 1 / store.inverse_mass[i];
    r.before += vec3(mass * store.velocity[i]);
    r.gravity += vec3((s.dt * mass) * s.gravity);
    if constexpr (std::remove_cvref_t<decltype(store)>::forced)
      r.forces += vec3(s.dt * store.force[i]);
    if (lost != 0) r.damping += vec3((-lost * mass) * solved_velocity(s, store, i, k));
    r.mass += mass;
  });
  r.ground += impulse_of_ground(s);
}

/// After positions have moved, before bodies are migrated.
template <class Scenario>
void close_momentum(world_state<Scenario>& s) {
  momentum_record& r = s.monitors.momentum;
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t) {
    const vec3 p = store.velocity[i] / store.inverse_mass[i];
    r.after += p;
    r.size += p.norm();
  });
}

}  // namespace talus::detail
