#pragma once
// The first half of a step of integrator<moreau_midpoint>: all bodies move to the middle of the
// step, where contacts are found and solved. Every rank moves its shadow copies as their owners do,
// with the same bits.
#include <cstddef>

#include "talus/features/driven/driven.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Moves body i of a shape by `dt`, with its present velocity.
template <class Store>
void drift_freely(Store& store, std::size_t i, real dt) {
  store.position[i] += dt * store.velocity[i];
  if constexpr (Store::tensor)
    store.angular_velocity[i] = rotate_freely(store.orientation_of[i], store.angular_velocity[i],
                                              store.shape[i].inertia(), dt);
  else if constexpr (Store::oriented)
    store.orientation_of[i] = turned<real>(store.orientation_of[i], dt * store.angular_velocity[i]);
}

/// Damps the velocities of body i of a shape, which are then those before the response.
template <class Scenario, class Store>
void damp_midway(world_state<Scenario>& s, Store& store, std::size_t i, real kept) {
  if constexpr (monitored<Scenario, energy_ledger>)
    if (i < store.locals) {
      const real motion = store.velocity[i].squaredNorm() / store.inverse_mass[i];
      const real spin =
          twice_spin_energy(store, i, store.pose(i).orientation, store.angular_velocity[i]);
      s.monitors.energy.running.damping += real(0.5) * (1 - kept * kept) * (motion + spin);
    }
  store.velocity[i] *= kept, store.angular_velocity[i] *= kept;
}

/// Driven bodies move by half of their step.
template <class Scenario>
void drift_driven(world_state<Scenario>& s) {
  each_driven(s, [&](auto& b, std::size_t i, driven_body& one) {
    if (one.next.end == one.state.at) return;
    rigid_place& at = one.state.at;
    at.point += (real(0.5) * s.dt) * one.next.v;
    if (const real speed = one.next.w.norm(); speed > 0)
      at.turn = after(rotation(one.next.w, real(0.5) * s.dt * speed), at.turn).normalized();
    put_driven(b, i, one.state);
  });
}

/// Moves all bodies to the middle of the step.
template <class Scenario>
void drift_to_midpoint(world_state<Scenario>& s) {
  const real half = real(0.5) * s.dt, kept = kept_by_damping(s);
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    using store_type = std::remove_reference_t<decltype(store)>;
    for (std::size_t i = 0; i < store.size(); ++i) {
      if (!store.moves(i)) continue;
      if constexpr (monitored<Scenario, energy_ledger> && store_type::tensor) {
        const auto spin_energy = [&] {
          return 0.5 *
                 twice_spin_energy(store, i, store.orientation_of[i], store.angular_velocity[i]);
        };
        const real before = spin_energy();
        drift_freely(store, i, half);
        if (i < store.locals) s.monitors.energy.running.scheme += spin_energy() - before;
      } else {
        drift_freely(store, i, half);
      }
      if constexpr (world_state<Scenario>::periodic)
        if (i >= store.locals) {  // the image takes the position of its body at the owner, and is
                                  // then shifted
          image_copy& copy = s.copies.of[k][i - store.locals];
          copy.home += half * store.velocity[i];
          store.position[i] = copy.home;
          if (copy.image != 0) store.position[i] += s.own.box().shift(copy.image);
        }
      if (kept != 1) damp_midway(s, store, i, kept);
    }
    ++k;
  });
  if constexpr (world_state<Scenario>::drives) drift_driven(s);
}

/// Before contacts are searched: resets the rotations of the last step.
template <class Scenario>
void clear_earlier_turns(world_state<Scenario>& s) {
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    auto& earlier = s.midpoints.earlier[k++];
    if constexpr (std::remove_cvref_t<decltype(b.movable)>::tensor)
      earlier.assign(b.movable.size(), {});
  });
}

}  // namespace talus::detail
