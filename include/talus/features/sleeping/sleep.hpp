#pragma once
// features<sleeping> in a step: islands that have rested long enough are put to sleep, and a body
// that approaches a sleeping island wakes it before they touch.
//
// A body carries the time for which its island has rested. In every step its owner adds dt, or
// resets the time if the body was too fast; every fourth step a rank takes the minimum over each
// part of an island that it sees, shadow copies included, whose value is that of the last step. So
// one fast body is known everywhere after some steps, without a collective call; and as the value
// grows alike on all ranks, an island is put to sleep on all of them in the same step. A woken body
// takes over the value of the body that woke it: all go back to sleep together, and waking ends
// even if an island is too large to notify in time. A joint must not hold a body that moves to one
// that sleeps: the ranks of an island of joints take one minimum over the whole of it, and wake it
// in one step (see features/sleeping/lowest_over_joints.hpp).
//
// With solver<reproducible> nothing may depend on the ranks. There the minimum of each whole
// island, and the waking bodies, are found by exchanges between neighbours until no value changes
// (label propagation over the islands), with one collective call for each round.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "talus/core/disjoint_sets.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/features/sleeping/lowest_over_joints.hpp"
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

/// Wakes the islands that something approaches, and notifies the neighbours. Returns whether any
/// body has woken, so that contacts must be found again.
template <class Scenario>
[[nodiscard]] bool wake_islands_in_step(world_state<Scenario>& s) {
  s.sleep.noted = false;
  meet_disturbed(s);
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

/// Adds the step to the rest time of each body owned here.
template <class Scenario>
void advance_sleep_timers(world_state<Scenario>& s) {
  const auto dt = static_cast<float>(s.dt);
  const real slow = s.sleep.settings.speed * s.sleep.settings.speed;
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    for (std::size_t i = 0; i < store.locals; ++i) {
      if (!store.moves(i)) continue;
      const real radius = store.shape[i].bounding_radius();
      const bool rests = store.velocity[i].squaredNorm() < slow &&
                         radius * radius * store.angular_velocity[i].squaredNorm() < slow;
      store.quiet[i] = rests ? store.quiet[i] + dt : 0;
    }
  });
  const auto forget = [](auto& store) {
    for (auto& flags : store.flags) flags &= static_cast<std::uint8_t>(~flag_disturbed);
  };
  s.each_shape([&](auto& b) { forget(b.movable), forget(b.global); });
}

/// Bodies joined by contacts or joints have the rest time of the least rested of them; for those
/// that touch a fixed body with a velocity, as on a belt, it is zero.
template <class Scenario>
void join_islands(world_state<Scenario>& s) {
  disjoint_sets& islands = s.sleep.islands;
  auto& island_timer = s.sleep.island_timer;
  const auto& bodies = s.solver.bodies;
  islands.reset(bodies.size());
  island_timer.assign(bodies.size(), std::numeric_limits<float>::infinity());
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i)
      if (!b.movable.moves(i)) {
        continue;
      } else if (i < b.movable.locals) {
        island_timer[b.first + i] = b.movable.quiet[i];
      } else if (!s.by_colours()) {  // otherwise, owners send it below
        island_timer[b.first + i] = b.movable.quiet[i] + static_cast<float>(s.dt);
      }
  });
  const auto carried = [&](std::size_t body, std::size_t by) {
    if (v_of(bodies[by]) != vec3(0, 0, 0) || w_of(bodies[by]) != vec3(0, 0, 0))
      island_timer[body] = 0;
  };
  s.each_constraint_list([&](const auto& list) {
    list.each([&](const auto& c, bool) {
      if constexpr (std::remove_cvref_t<decltype(c)>::paired) {
        const auto a = static_cast<std::uint32_t>(c.a), b = static_cast<std::uint32_t>(c.b);
        if (bodies[a].inverse_mass == 0)
          carried(b, a);
        else if (bodies[b].inverse_mass == 0)
          carried(a, b);
        else
          islands.join(a, b);
      }
    });
  });
  for (std::uint32_t k = 0; k < islands.size(); ++k) {
    float& all = island_timer[islands.root(k)];
    all = std::min(all, island_timer[k]);
  }
  if constexpr (world_state<Scenario>::has_joints)
    if (!s.by_colours())
      take_lowest_over_joints(
          s, false, [&](std::size_t, const joint_end& end) { return islands.root(end.number); },
          island_timer);
  if constexpr (world_state<Scenario>::may_use_colours &&
                !world_state<Scenario>::link_type::alone) {
    if (!s.by_colours()) return;
    plain_vector<real> values(islands.size());
    for (bool lower = true; lower; lower = anywhere(s, lower)) {
      for (std::uint32_t k = 0; k < islands.size(); ++k) values[k] = island_timer[islands.root(k)];
      shared_velocities<Scenario>(s).share_values(values);
      lower = false;
      for (std::uint32_t k = 0; k < islands.size(); ++k) {
        float& all = island_timer[islands.root(k)];
        if (const auto there = static_cast<float>(values[k]); there < all)
          all = there, lower = true;
      }
    }
  }
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
      store.quiet[i] = s.sleep.island_timer[s.sleep.islands.root(b.first + i)];
      if (store.quiet[i] < long_enough) continue;
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
