#pragma once
// The stages of a step with soft contacts: forces from overlaps, velocities from forces, positions
// from velocities.
#include <algorithm>
#include <cmath>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/portable_powers.hpp"
#include "talus/features/energy_ledger/soft_ledger.hpp"
#include "talus/ghosts/velocities_of_owners.hpp"
#include "talus/interaction/composed_law.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/pairs/flush_bodies.hpp"
#include "talus/pairs/found_pairs.hpp"
#include "talus/pairs/neighbour_list.hpp"
#include "talus/state/state.hpp"
#include "talus/step/detect.hpp"
#include "talus/step/finite_motion.hpp"
#include "talus/step/soft_forces.hpp"
#include "talus/step/sphere_forces.hpp"

namespace talus::detail {

/// Calls f(store, index of its first body in soft.bodies) for the bodies that can move.
template <class Scenario, class F>
void each_movable_store(held_bodies<Scenario>& s, F&& f) {
  s.each_finite_shape([&](auto& b) { f(b.movable, b.first); });
}

/// Reads the motion of all bodies, and resets the sums of their forces to zero.
template <class Scenario>
void gather_motion(world_state<Scenario>& s) {
  s.soft.pairs.follow(s.materials);
  s.each_finite_shape([&](auto& b) {
    const auto& [store, first, reach] = std::tie(b.movable, b.first, b.reach);
    for (std::size_t i = 0; i < store.size(); ++i) {
      const real radius = sphere_radius(store.shape[i]);
      s.soft.bodies[first + i] = {
          .v = store.velocity[i],
          .inverse_mass = store.inverse_mass[i],
          .w = store.angular_velocity[i],
          .radius = radius,
          .curvature = store.fixed(i) ? wall_curvature(store.shape[i]) : 1 / radius};
      s.soft.places[first + i] = {store.position[i], reach[i]};
    }
  });
}

/// Finds the pairs of the present state, for an observer. Changes nothing that a step depends on.
template <class Scenario>
void prepare_observation(world_state<Scenario>& s) {
  std::vector<bool> changed;  // for the next step to read
  s.each_shape([&](const auto& b) { changed.push_back(b.globals_changed); });
  prepare_detection(s);
  std::size_t k = 0;
  s.each_shape([&](auto& b) { b.globals_changed = changed[k++]; });
  update_flush_bodies(s);
  gather_motion(s);
}

/// Calls observer(key, force on a, acts_on_a, acts_on_b) for all contacts of the present state;
/// over all ranks each acts on each of its bodies once; or observer(key, geometry, force on a,
/// counts_here), where each counts on one rank; or observer(key, point, centre of a, centre of b,
/// force and moment on a, counts_here); or adds up their stored energies. No rank waits for
/// another, and shadow copies have the velocities that they have. Changes nothing that a step
/// depends on.
template <class Scenario, class Observer>
void observe_contacts(world_state<Scenario>& s, Observer&& observer) {
  prepare_observation(s);
  each_neighbour_pair(s, [&]<class A, class B, partner P>() {
    return force_adder<Scenario, A, B, P, std::remove_reference_t<Observer>>(s, observer);
  });
}

/// Collective: the same between two steps. All ranks of a contact see the same force.
template <class Scenario, class Observer>
void observe_forces(world_state<Scenario>& s, Observer&& observer) {
  if constexpr (Scenario::integrator::shares_midway && !world_state<Scenario>::link_type::alone)
    refresh_velocities(s);
  observe_contacts(s, observer);
}

/// The energies of the springs in the present state. Searches for pairs only if those of the last
/// search do not hold.
template <class Scenario>
[[nodiscard]] spring_energies survey_springs(world_state<Scenario>& s) {
  spring_energies e;
  if (!pairs_hold_unchanged(s)) {
    observe_contacts(s, e);
    return e;
  }
  update_flush_bodies(s);
  if constexpr (Scenario::integrator::shares_midway) {
    count_bodies(s);
    gather_motion(s);
  } else {  // the forces of this step have done so, and stored energies depend on places alone
    s.each_finite_shape([&](auto& b) {
      for (std::size_t i = 0; i < b.movable.size(); ++i)
        s.soft.places[b.first + i] = {b.movable.position[i], b.reach[i]};
    });
  }
  each_found_pair(s, [&]<class A, class B, partner P>() {
    if constexpr (forces_in_packs<Scenario, A, B, P>)
      return sphere_forces<Scenario, spring_energies>(s, e);
    else
      return force_adder<Scenario, A, B, P, spring_energies>(s, e);
  });
  return e;
}

// The energy of the springs at both ends of a step, for the energy ledger. Forces are computed at
// one of them, at the start or (Verlet) at the end; the energy at the other one is computed
// separately.

/// After the forces at the start of a step: the springs at the end of the last one, if they have
/// not been measured since, and at the start of this one.
template <class Scenario>
void open_springs_as_measured(step_records<Scenario>& s) {
  spring_record& r = s.monitors.springs;
  signed_sum energy = r.normal;
  (energy += r.released) += r.across_before;
  if (std::exchange(r.undisturbed, false)) {
    r.unclosed -= r.across_before;
    close_springs(s, energy, r.unclosed);
  }
  open_springs(s, energy);
}

/// Forces and torques of all contacts, from the present positions and velocities; the springs of
/// the contacts are advanced by dt. Needs the pairs of find_close_pairs().
template <class Scenario>
void measure_forces(world_state<Scenario>& s) {
  using law = typename world_state<Scenario>::law;
  update_flush_bodies(s);
  gather_motion(s);
  auto& count = std::get<soft_contacts>(s.contacts);
  if constexpr (law::remembers) s.recorded.reset(count.size());
  if constexpr (world_state<Scenario>::drives) forget_forces(s);
  count = {};
  if constexpr (monitored<Scenario, residual_monitor>) s.soft.squares_of_forces = {};
  if constexpr (monitored<Scenario, penetration_monitor>) s.monitors.overlaps.reset();
  if constexpr (monitored<Scenario, energy_ledger>) {
    s.monitors.springs.measure_anew();
  }
  if constexpr (monitored<Scenario, momentum_balance>)
    s.monitors.momentum.ground_force = vec3(0, 0, 0);
  std::nullptr_t nobody = nullptr;
  each_found_pair(s, [&]<class A, class B, partner P>() {
    if constexpr (forces_in_packs<Scenario, A, B, P>)
      return sphere_forces<Scenario, std::nullptr_t>(s, nobody);
    else
      return force_adder<Scenario, A, B, P, std::nullptr_t>(s, nobody);
  });
  if constexpr (law::remembers) s.recorded.hold_places(), std::swap(s.history, s.recorded);
  if constexpr (monitored<Scenario, energy_ledger> && !Scenario::integrator::shares_midway)
    open_springs_as_measured(s);

  each_movable_store(s, [&](auto& store, std::size_t first) {
    if constexpr (std::remove_reference_t<decltype(store)>::keeps_contact_forces)
      for (std::size_t i = 0; i < store.locals; ++i) {
        store.contact_force[i] = s.soft.bodies[first + i].force;
        store.contact_torque[i] = s.soft.bodies[first + i].torque;
      }
  });
}

/// At the end of a step: the next one, or close_ledger(), closes it.
template <class Scenario>
void leave_springs_open(step_records<Scenario>& s) {
  spring_record& r = s.monitors.springs;
  close_step(s);
  r.unclosed = r.yielded;
  r.unclosed += r.across;
  r.undisturbed = true;
}
template <class Scenario>
void open_springs_midway(world_state<Scenario>& s) {
  spring_record& r = s.monitors.springs;
  if (std::exchange(r.undisturbed, false)) {
    r.across_at_start = r.across;
    r.start = r.stored;
    return;
  }
  const spring_energies now = survey_springs(s);
  r.across_at_start = now.across;
  open_springs(s, now.sum());
}
template <class Scenario>
void close_springs_as_measured(step_records<Scenario>& s) {
  spring_record& r = s.monitors.springs;
  signed_sum energy = r.normal, lost = r.yielded;
  (lost += r.across_at_start) -= r.across_before;
  close_step(s);
  close_springs(s, energy += r.across, lost);
  r.undisturbed = true;
}

/// Completes the ledger of the last step, if that is still open: before anything but the steps
/// reads the ledger, or changes what it books.
template <class Scenario>
void close_ledger(world_state<Scenario>& s) {
  if constexpr (Scenario::contact_law::soft && monitored<Scenario, energy_ledger>) {
    spring_record& r = s.monitors.springs;
    if (!std::exchange(r.undisturbed, false)) return;
    if constexpr (!Scenario::integrator::shares_midway) {
      const spring_energies now = survey_springs(s);
      r.unclosed -= now.across;
      close_springs(s, now.sum(), r.unclosed);
    }
  }
}

/// Velocities of the bodies owned here, after their contacts, gravity and the user's forces have
/// acted for the time `h`. A drift over the time `drift` follows, or 0.
template <forces_of Forces, class Scenario>
void kick(world_state<Scenario>& s, real h, [[maybe_unused]] real drift) {
  const real kept = s.damping == 1 ? 1 : portable::pow(s.damping, h);
  [[maybe_unused]] auto sums = kick_sums_of(s);
  each_movable_store(s, [&](auto& store, std::size_t first) {
    using store_type = std::remove_reference_t<decltype(store)>;
    for (std::size_t i = 0; i < store.locals; ++i) {
      const real inverse_mass = store.inverse_mass[i];
      if (inverse_mass == 0) continue;
      vec3 force, torque;
      if constexpr (store_type::keeps_contact_forces) {
        force = store.contact_force[i];
        torque = store.contact_torque[i];
      } else {
        force = s.soft.bodies[first + i].force;
        torque = s.soft.bodies[first + i].torque;
      }
      [[maybe_unused]] const vec3 of_contacts = force, turn_of_contacts = torque;
      if constexpr (store_type::forced) {
        force += store.force[i];
        torque += store.torque[i];
      }
      if constexpr (store_type::tensor) {
        const quat q = store.orientation_of[i];
        torque = q * vec3((q.conjugate() * torque).cwiseQuotient(store.shape[i].inertia()));
      } else {
        torque *= 1 / store.shape[i].inertia()[0];
      }
      const vec3 dv = h * (inverse_mass * force + s.gravity), dw = (h * inverse_mass) * torque;
      if constexpr (monitored<Scenario, energy_ledger> || monitored<Scenario, momentum_balance>)
        book_kick<Forces>(s, sums, store, i, h, drift, kept, of_contacts, turn_of_contacts, dv, dw);
      store.velocity[i] = kept * (store.velocity[i] + dv);
      store.angular_velocity[i] = kept * (store.angular_velocity[i] + dw);
    }
  });
  if constexpr (monitored<Scenario, energy_ledger> || monitored<Scenario, momentum_balance>)
    book_kick_of_contacts<Forces>(s, h);
}

/// Positions and orientations of the bodies owned here, after free motion for the time `h`. The
/// scheme takes what a rotation changes of the energy.
template <class Scenario>
void drift(world_state<Scenario>& s, real h) {
  [[maybe_unused]] auto sums = kick_sums_of(s);
  each_movable_store(s, [&](auto& store, std::size_t) {
    using store_type = std::remove_reference_t<decltype(store)>;
    finite_watch watch;
    for (std::size_t i = 0; i < store.locals; ++i) {
      if (store.inverse_mass[i] == 0) continue;
      store.position[i] += h * store.velocity[i];
      if constexpr (store_type::tensor) {
        const auto spin = [&] {
          return twice_spin_energy(store, i, store.orientation_of[i], store.angular_velocity[i]);
        };
        if constexpr (monitored<Scenario, energy_ledger>) sums.scheme -= 0.5 * spin();
        store.angular_velocity[i] = rotate_freely(
            store.orientation_of[i], store.angular_velocity[i], store.shape[i].inertia(), h);
        if constexpr (monitored<Scenario, energy_ledger>) sums.scheme += 0.5 * spin();
      } else if constexpr (store_type::oriented) {
        store.orientation_of[i] =
            turned<real>(store.orientation_of[i], vec3(h * store.angular_velocity[i]));
      }
      watch.look(store.position[i]);
      watch.look(store.angular_velocity[i]);
      if constexpr (store_type::oriented) watch.look(store.orientation_of[i]);
    }
    if (watch.doubtful()) refuse_infinite_motion(s, store);
  });
}

/// Resets the user's forces after a step.
template <class Scenario>
void end_forces(held_bodies<Scenario>& s) {
  each_movable_store(s, [&](auto& store, std::size_t) {
    if constexpr (std::remove_reference_t<decltype(store)>::forced) {
      std::fill(store.force.begin(), store.force.end(), vec3(0, 0, 0));
      std::fill(store.torque.begin(), store.torque.end(), vec3(0, 0, 0));
    }
  });
}

}  // namespace talus::detail
