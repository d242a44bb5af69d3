#pragma once
// Velocities of a body before contacts act on it, and after.
#include <cstddef>
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Whether contacts bear loads. Without gravity, forces or driven bodies their impulses are impacts
/// only.
template <class Scenario>
[[nodiscard]] bool presses(const world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::drives)
    if (!s.driving.all.empty()) return true;
  return contains_type<typename Scenario::features, forces> || s.gravity != vec3(0, 0, 0);
}
/// Whether impacts are solved to round-off, together with all ranks; see solver/finish_impacts.hpp.
template <class Scenario>
[[nodiscard]] bool finishes_impacts(const world_state<Scenario>& s) {
  return !world_state<Scenario>::has_joints && s.materials.rebounds() && !presses(s) &&
         s.settings.tolerance == 0;
}

/// The part of all velocities that damping leaves where it acts: at the end of the response, and
/// with the midpoint, whose step is of second order thereby, at its beginning too.
template <class Scenario>
[[nodiscard]] real kept_by_damping(const world_state<Scenario>& s) {
  const real time = world_state<Scenario>::midpoint ? real(0.5) * s.dt : s.dt;
  return s.damping == 1 ? 1 : portable::pow(s.damping, time);
}

// Always inlined: each is a line or two of the loops that call it.

/// After forces.
template <class Store>
[[nodiscard]] [[gnu::always_inline]] inline vec3 free_velocity(const step_conditions& s,
                                                               const Store& store, std::size_t i) {
  vec3 v = store.velocity[i];
  if (!store.moves(i)) return v;
  v += s.dt * s.gravity;
  if constexpr (Store::forced) v += (s.dt * store.inverse_mass[i]) * store.force[i];
  return v;
}
/// The angular velocity of body `k` of the solver's arrays, which have its tensor.
template <class Scenario, class Store>
[[nodiscard]] [[gnu::always_inline]] inline vec3 free_spin(const world_state<Scenario>& s,
                                                           const Store& store, std::size_t i,
                                                           std::size_t k) {
  vec3 w = store.angular_velocity[i];
  if constexpr (Store::forced)
    if (store.moves(i)) {
      if constexpr (Store::tensor)
        w += s.dt * (s.solver.tensor(k) * store.torque[i]);
      else
        w += (s.dt * (store.inverse_mass[i] * (1 / store.shape[i].inertia()[0]))) * store.torque[i];
    }
  return (void)k, w;
}

/// `before` plus its change by the contacts: velocities without contacts keep all digits, although
/// the solve is in lower precision. (The difference is one of floats: when GCC 12 vectorises
/// (double)(float)x, it omits the rounding.)
template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline vec3 changed_from(const vec3& before,
                                                              const vector3<Real>& after) {
  return before + in_scalar<real>(vector3<Real>(after - in_scalar<Real>(before)));
}

/// After the response, until the body has moved. Velocities before it are still in the store.
template <class Scenario, class Store>
[[nodiscard]] [[gnu::always_inline]] inline decltype(auto) solved_velocity(
    const world_state<Scenario>& s, const Store& store, std::size_t i, std::size_t k) {
  if constexpr (std::is_same_v<solved_scalar<Scenario>, real>)
    return (s.solver.bodies[k].v);
  else
    return changed_from(free_velocity(s, store, i), s.solver.bodies[k].v);
}
template <class Scenario, class Store>
[[nodiscard]] [[gnu::always_inline]] inline decltype(auto) solved_spin(
    const world_state<Scenario>& s, const Store& store, std::size_t i, std::size_t k) {
  if constexpr (std::is_same_v<solved_scalar<Scenario>, real>)
    return (s.solver.bodies[k].w);
  else
    return changed_from(free_spin(s, store, i, k), s.solver.bodies[k].w);
}

}  // namespace talus::detail
