#pragma once
// features<sleeping> in a step: islands that have rested long enough are put to sleep, and a body
// that approaches a sleeping island wakes it before they touch.
//
// A body carries the time for which its island has rested. In every step its owner adds dt, or
// resets the time if the body did not rest (see features/sleeping/rest.hpp); every fourth step a
// rank takes the minimum over each part of an island that it sees, shadow copies included, whose
// value is that of the last step. So one body that moves is known everywhere after some steps,
// without a collective call; and as the value grows alike on all ranks, an island is put to sleep
// on all of them in the same step. A woken body takes over the value of the body that woke it: all
// go back to sleep together, and waking ends even if an island is too large to notify in time. A
// joint must not hold a body that moves to one that sleeps: the ranks of an island of joints take
// one minimum over the whole of it, and wake it in one step (see
// features/sleeping/lowest_over_joints.hpp).
//
// An island also needs something immovable that bears it. The time since then spreads as the rest
// time does. It begins with a very large value, which is also that of an island that has lost what
// bore it.
//
// With solver<reproducible> nothing may depend on the ranks. There the minimum of each whole
// island, and the waking bodies, are found by exchanges between neighbours until no value changes
// (label propagation over the islands), with one collective call for each round.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "talus/constraint/contact_work.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/features/sleeping/lowest_over_joints.hpp"
#include "talus/features/sleeping/rest.hpp"
#include "talus/features/sleeping/sleeping_islands.hpp"
#include "talus/ghosts/migrate_and_refresh.hpp"
#include "talus/ghosts/shared_velocities.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The memory of contacts follows the bodies that fell asleep or woke.
template <class Scenario>
void note_changed_sleepers(world_state<Scenario>& s) {
  if (std::exchange(s.sleep.changed, false)) note_sleepers(s);
}

/// Wakes all islands with a waking body, on all ranks in this step, on however many ranks an island
/// lies: for solvers whose results must not depend on the ranks. Shadow copies equal their owners'
/// bodies.
template <class Scenario>
void wake_everywhere(world_state<Scenario>& s) {
  while (anywhere(s, wakes_pend(s))) {
    wake_islands(s);
    if constexpr (!world_state<Scenario>::link_type::alone) {
      const stage_clock clock(s.seconds.exchange);
      share_shadow_copies(s, false);
    } else {
      note_changed_sleepers(s);
    }
  }
}

/// Records the sleeping bodies owned here that a change of an immovable body by the user concerns,
/// or its motion if it is driven: those near it, and those that contacts or joints connect with it.
/// A body that the user has released counts, too.
template <class Scenario>
void meet_disturbed(world_state<Scenario>& s) {
  const auto meet = [&](const auto& store, std::size_t j) {
    using B = typename std::remove_cvref_t<decltype(store)>::shape_type;
    s.each_finite_shape([&](const auto& of_a) {
      const auto& a = of_a.movable;
      for (std::size_t i = 0; i < a.locals; ++i) {
        if (!a.asleep(i)) continue;
        if constexpr (B::finite) {
          const real reach = (1 + contact_slack) *
                             (a.shape[i].bounding_radius() + store.shape[j].bounding_radius());
          const real ahead = steps_of_warning * s.dt * store.velocity[j].norm();
          if ((a.position[i] - store.position[j]).norm() > reach + ahead) continue;
        }
        if (about_to_touch(s, a, i, store, j)) s.sleep.touched.push_back({a.id[i], 0});
      }
    });
  };
  if (s.sleep.asleep.empty()) return;
  plain_vector<system_id> disturbed;
  s.each_shape([&](const auto& b) {
    const auto look = [&](const auto& store) {
      for (std::size_t j = 0; j < store.size(); ++j)
        if ((store.flags[j] & flag_disturbed) != 0) {
          disturbed.push_back(store.id[j]);
          if (store.inverse_mass[j] == 0) meet(store, j);
        }
    };
    look(b.movable), look(b.global);
  });
  if (disturbed.empty()) return;
  sort_values(disturbed);
  const auto moved = [&](system_id id) {
    return std::binary_search(disturbed.begin(), disturbed.end(), id);
  };
  const auto meets = [&](system_id a, system_id b) {
    s.sleep.spreads = s.sleep.spreads || moved(a) || moved(b);
  };
  for (const auto& c : s.sleep.contacts.entries()) meets(c.key.a, c.key.b);
  if constexpr (world_state<Scenario>::has_joints)
    s.joints.each_kind([&](const auto& of_kind) {
      for (const auto& r : of_kind.records) meets(r.key.a, r.key.b);
    });
}

/// Records the sleeping bodies owned here on which fields exert another force than in their first
/// step at rest, and the forces on the others. At rest a fluid drags less than at the velocity with
/// which a body fell asleep: the force of the first step may differ by more from the one before.
template <class Scenario>
void meet_fields(world_state<Scenario>& s) {
  constexpr real change = 1e-6, change_at_first = 1e-2;
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    if constexpr (std::remove_reference_t<decltype(store)>::forced)
      for (std::size_t i = 0; i < store.locals; ++i) {
        if (store.inverse_mass[i] == 0) continue;
        drift_while_slow& m = store.drift[i];
        const bool first = store.asleep(i) && m.since < 0;
        const real size = m.load.norm() + s.gravity.norm() / store.inverse_mass[i];
        if (store.asleep(i) &&
            (store.force[i] - m.load).norm() > (first ? change_at_first : change) * size)
          s.sleep.touched.push_back({store.id[i], 0});
        else if (first || !store.asleep(i))
          m.load = store.force[i];
        if (first) m.since = 0;
      }
  });
}

/// Wakes the islands that something approaches, and notifies the neighbours. Returns whether any
/// body has woken, so that contacts must be found again.
template <class Scenario>
[[nodiscard]] bool wake_islands_in_step(world_state<Scenario>& s) {
  s.sleep.noted = false;
  meet_disturbed(s);
  meet_fields(s);
  if constexpr (world_state<Scenario>::may_use_colours)
    if (s.by_colours()) {
      wake_everywhere(s);
      return s.sleep.noted;
    }
  wake_islands(s, true);
  if constexpr (!world_state<Scenario>::link_type::alone) {
    const stage_clock clock(s.seconds.exchange);
    share_shadow_copies(s, false);
  } else {
    note_changed_sleepers(s);
  }
  return s.sleep.noted;
}

/// The way of a body in this step and its turn, over dt: with those of the position correction.
template <class Scenario, class Store>
[[nodiscard]] plain_pair<vec3, vec3> motion_in_step(const world_state<Scenario>& s,
                                                    const Store& store, std::size_t i,
                                                    std::size_t k) {
  vec3 v = store.velocity[i], w = store.angular_velocity[i];
  if constexpr (world_state<Scenario>::law::correction) {
    v += in_scalar<real>(s.solver.shift[k].v);
    if constexpr (Store::tensor) w += s.solver.turn[k - s.solver.first_tensor].w;
  }
  return {v, w};
}

/// Adds the step to the rest time of each body owned here.
template <class Scenario>
void advance_sleep_timers(world_state<Scenario>& s) {
  const auto dt = static_cast<float>(s.dt);
  const real slow = s.sleep.settings.speed * s.sleep.settings.speed;
  // Other ranks learn of it before the island may fall asleep.
  const rest_judge judge(s.sleep.settings.time / 3, s.dt);
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    for (std::size_t i = 0; i < store.locals; ++i) {
      if (!store.moves(i)) continue;
      const real radius = store.shape[i].bounding_radius();
      const vec3 &v = store.velocity[i], &w = store.angular_velocity[i];
      const bool is_slow = v.squaredNorm() < slow && radius * radius * w.squaredNorm() < slow;
      const auto [moved, turned] = motion_in_step(s, store, i, b.first + i);
      const bool rests = is_slow && judge.add(store.drift[i], radius, v, w, moved, turned);
      if (!is_slow) rest_judge::restart(store.drift[i]);
      store.quiet[i] = rests ? store.quiet[i] + dt : 0;
      store.unborne[i] += dt;
    }
  });
  const auto forget = [](auto& store) {
    for (auto& flags : store.flags) flags &= static_cast<std::uint8_t>(~flag_disturbed);
  };
  s.each_shape([&](auto& b) { forget(b.movable), forget(b.global); });
}

/// Whether a constraint exerts an impulse; joints always count.
template <class Constraint>
[[nodiscard]] bool bears(const Constraint& c) {
  if constexpr (is_joint<Constraint>)
    return true;
  else
    return impulse_in_parts(c).normal != vec3(0, 0, 0);
}

/// Replaces the values of the bodies of each island by the least of them, on all ranks of an island
/// of joints, and with solvers whose results must not depend on the ranks, on all of any island.
template <class Scenario>
void take_least(world_state<Scenario>& s, plain_vector<float>& values) {
  disjoint_sets& islands = s.sleep.islands;
  const auto spread = [&] {
    for (std::uint32_t k = 0; k < islands.size(); ++k) {
      float& all = values[islands.root(k)];
      all = std::min(all, values[k]);
    }
    for (std::uint32_t k = 0; k < islands.size(); ++k) values[k] = values[islands.root(k)];
  };
  spread();
  if constexpr (world_state<Scenario>::has_joints)
    if (!s.by_colours()) {
      take_lowest_over_joints(
          s, false, [&](std::size_t, const joint_end& end) { return islands.root(end.number); },
          values);
      for (std::uint32_t k = 0; k < islands.size(); ++k) values[k] = values[islands.root(k)];
    }
  if constexpr (world_state<Scenario>::may_use_colours &&
                !world_state<Scenario>::link_type::alone) {
    if (!s.by_colours()) return;
    plain_vector<real> there(islands.size());
    for (bool lower = true; lower; lower = anywhere(s, lower)) {
      for (std::uint32_t k = 0; k < islands.size(); ++k) there[k] = values[k];
      shared_velocities<Scenario>(s).share_values(there);
      lower = false;
      for (std::uint32_t k = 0; k < islands.size(); ++k)
        if (const auto value = static_cast<float>(there[k]); value < values[k])
          values[k] = value, lower = true;
      spread();
    }
  }
}

/// Bodies joined by contacts or joints have the rest time of the least rested of them. It is zero
/// for those that touch an immovable body with a velocity, as on a belt, and for those that nothing
/// immovable bears, unless they stand still.
template <class Scenario>
void join_islands(world_state<Scenario>& s) {
  disjoint_sets& islands = s.sleep.islands;
  auto &quiet = s.sleep.island_timer, &unborne = s.sleep.island_unborne;
  const auto& bodies = s.solver.bodies;
  constexpr float never = std::numeric_limits<float>::infinity();
  constexpr float never_borne = columns::unborne::initial;
  islands.reset(bodies.size());
  quiet.assign(bodies.size(), never), unborne.assign(bodies.size(), never);
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      if (!b.movable.moves(i)) continue;
      const bool own = i < b.movable.locals;
      if (!own && s.by_colours()) continue;  // owners send these values
      const float since = own ? 0 : static_cast<float>(s.dt);
      quiet[b.first + i] = b.movable.quiet[i] + since;
      // A value of the last time that nothing renews now is of something that is gone.
      const bool lost = own && b.movable.unborne[i] < (steps_between_rests + 1) * s.dt;
      unborne[b.first + i] = lost ? never_borne : b.movable.unborne[i] + since;
    }
  });
  const auto meet_immovable = [&](std::size_t body, std::size_t by, const auto& c) {
    if (v_of(bodies[by]) != vec3(0, 0, 0) || w_of(bodies[by]) != vec3(0, 0, 0)) quiet[body] = 0;
    if (bears(c)) unborne[body] = 0;
  };
  s.each_constraint_list([&](const auto& list) {
    list.each([&](const auto& c, bool) {
      const auto a = static_cast<std::uint32_t>(c.a);
      if constexpr (std::remove_cvref_t<decltype(c)>::paired) {
        const auto b = static_cast<std::uint32_t>(c.b);
        if (bodies[a].inverse_mass == 0)
          meet_immovable(b, a, c);
        else if (bodies[b].inverse_mass == 0)
          meet_immovable(a, b, c);
        else
          islands.join(a, b);
      } else if (bears(c)) {
        unborne[a] = 0;
      }
    });
  });
  take_least(s, unborne);
  // What bears an island may be known some steps later on other ranks.
  const auto long_unborne =
      static_cast<float>(std::max(s.sleep.settings.time, steps_to_tell * s.dt));
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i) {
      const std::size_t k = b.first + i;
      if (b.movable.moves(i) && unborne[k] > long_unborne &&
          !rest_judge::stands_still(b.movable.drift[i], b.movable.shape[i].bounding_radius()))
        quiet[k] = 0;
    }
  });
  take_least(s, quiet);
}

/// After positions have moved: puts to sleep the islands that have rested long enough.
template <class Scenario>
void put_to_sleep(world_state<Scenario>& s) {
  advance_sleep_timers(s);
  if (s.steps % steps_between_rests != 0) return;
  join_islands(s);
  const auto long_enough = static_cast<float>(s.sleep.settings.time);
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    for (std::size_t i = 0; i < store.locals; ++i) {
      if (!store.moves(i)) continue;
      store.quiet[i] = s.sleep.island_timer[b.first + i];
      store.unborne[i] = s.sleep.island_unborne[b.first + i];
      if (store.quiet[i] < long_enough) continue;
      rest_judge::restart(store.drift[i]);
      store.drift[i].since = -1;
      if constexpr (monitored<Scenario, energy_ledger>)
        s.monitors.energy.running.sleep +=
            0.5 *
            (store.velocity[i].squaredNorm() / store.inverse_mass[i] +
             twice_spin_energy(store, i, store.pose(i).orientation, store.angular_velocity[i]));
      store.velocity[i] = store.angular_velocity[i] = vec3(0, 0, 0);
      store.flags[i] |= flag_asleep;
      s.sleep.changed = true;
    }
  });
}

}  // namespace talus::detail
