#pragma once
// Accelerations that depend on position and time: gravity of a centre, a wind, a vibrating frame.
#include <string>
#include <type_traits>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/scenario/scenario.hpp"

namespace talus {

/// Accelerates all movable bodies by f(position of the centre, time), in addition to gravity. It
/// acts as a force of the user, in each step with its value at the start, and with
/// integrator<moreau_midpoint> with that in the middle, so that the step is of second order. It
/// needs no messages: f must return the same bits on all ranks. Where it changes, sleeping bodies
/// wake. The summary gives its time under `name`. All ranks make the same call. Throws
/// runtime_error if f is not finite. Needs features<forces>.
template <class World, class F>
void add_force_field(World& w, F f, const std::string& name = "force field") {
  using scenario = typename World::scenario_type;
  if constexpr (detail::require_feature<scenario, forces>()) {
    w.require_all_ranks("add_force_field", false);
    w.act_each_step(name, [&w, f = std::move(f)](real time) {
      auto& s = detail::state_of(w);
      s.each_finite_shape([&](auto& b) {
        auto& store = b.movable;
        for (std::size_t i = 0; i < store.size(); ++i) {  // shadow copies too, as their owners do
          if (store.inverse_mass[i] == 0) continue;
          const vec3 a = f(store.position[i], time);
          if (!detail::finite(a))
            detail::fail<std::runtime_error>(
                "the force field is {} at {}, where body {} is at time {}: it must be finite", a,
                store.position[i], store.id[i], time);
          store.force[i] += a / store.inverse_mass[i];
        }
      });
    });
  }
}

}  // namespace talus
