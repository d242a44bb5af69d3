#pragma once
// features<momentum_balance>: its record, how it books a step (the momentum gained by the bodies,
// and its sources), and its stages.
#include <cmath>

#include "talus/constraint/contact_work.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"

namespace talus {
namespace detail {

struct momentum_record {
  vector_sum before, after;  ///< momentum of the bodies owned here
  vector_sum gravity, forces, damping;
  vector_sum ground;           ///< from global and fixed bodies
  vec3 ground_force{0, 0, 0};  ///< of soft contacts, when they were computed
  exact_sum mass, size;        ///< of the bodies that can move; sum of |m v|

  template <class Visitor>
  void each_number(Visitor& visit) {
    visit.sums(before, after, gravity, forces, damping, ground, ground_force);
    visit.sums(mass, size);
  }
};

/// Adds the impulse that global and fixed bodies exerted in the last step on the bodies of this
/// rank.
template <class Scenario>
void add_impulse_of_ground(const world_state<Scenario>& s, vector_sum& sum) {
  const auto& solver = s.solver;
  s.each_constraint_list([&](const auto& list) {
    list.each_acting([&](const auto& c, bool on_a, bool on_b) {
      if (!on_a || !on_b) return;  // both can move
      const auto give = [&](real sign) { sum += vec3(sign * impulse_on_a(c)); };
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
}

/// After the response, before positions move. Contacts between movable bodies contribute nothing in
/// sum; the balance would show it if the two sides of a contact across ranks contributed
/// differently.
template <class Scenario>
void book_momentum(world_state<Scenario>& s) {
  momentum_record& r = s.monitors.momentum;
  r = {};
  const real kept = kept_by_damping(s), lost = 1 - kept;
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t k) {
    if (!store.moves(i)) return;
    const real mass = 1 / store.inverse_mass[i];
    vec3 first = mass * store.velocity[i];
    if constexpr (world_state<Scenario>::midpoint)
      if (lost != 0) first /= kept, r.damping += vec3(-lost * first);
    r.before += first;
    r.gravity += vec3((s.dt * mass) * s.gravity);
    if constexpr (std::remove_cvref_t<decltype(store)>::forced)
      r.forces += vec3(s.dt * store.force[i]);
    if (lost != 0) r.damping += vec3((-lost * mass) * solved_velocity(s, store, i, k));
    r.mass += mass;
  });
  add_impulse_of_ground(s, r.ground);
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

/// Begins the momentum balance of a step of soft contacts.
template <class Scenario>
void open_momentum(world_state<Scenario>& s) {
  momentum_record& r = s.monitors.momentum;
  r = {};
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t) {
    r.before += vec3(store.velocity[i] / store.inverse_mass[i]);
    r.mass += 1 / store.inverse_mass[i];
  });
}

}  // namespace detail

struct momentum_balance::record {
  detail::momentum_record momentum;

  template <class F>
  void each_record(F&& f) {
    f("momentum", momentum);
  }
};

struct momentum_balance::hooks {
  template <class Scenario>
  static void at_start(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::contact_law::soft) open_momentum(s);
  }
  template <class Scenario>
  static void after_solve(detail::world_state<Scenario>& s) {
    if constexpr (!Scenario::contact_law::soft) book_momentum(s);
  }
  /// Before resting islands lose the rest of their motion.
  template <class Scenario>
  static void after_move(detail::world_state<Scenario>& s) {
    if constexpr (!Scenario::contact_law::soft) close_momentum(s);
  }
  template <class Scenario>
  static void at_close(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::contact_law::soft) close_momentum(s);
  }
};

}  // namespace talus
