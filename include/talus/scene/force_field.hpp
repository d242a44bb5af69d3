#pragma once
// Accelerations that depend on position and time: gravity of a centre, a wind, a vibrating frame.
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/scenario/scenario.hpp"

namespace talus {

/// Accelerates all movable bodies by f(position of the centre, time), in addition to gravity, in
/// the steps of simulate(). It acts as a force of the user, in each step with its value at the
/// start. It needs no messages: f must return the same bits on all ranks. Where it
/// changes, sleeping bodies wake. Bodies added after a step by an observer that runs later than
/// this one are accelerated from the next step but one. `name` identifies its state in checkpoints
/// and must be unique. All ranks make the same call. Throws runtime_error if f is not finite. Needs
/// features<forces>.
template <class World, class F>
void add_force_field(World& w, F f, const std::string& name = "force field") {
  using scenario = typename World::scenario_type;
  if constexpr (detail::require_feature<scenario, forces>()) {
    w.require_all_ranks("add_force_field", false);
    struct record {
      std::uint64_t next = ~std::uint64_t{0};  ///< the step for which forces have been added
    };
    const auto done = std::make_shared<record>();
    const auto act = [&w, f = std::move(f), done] {
      if (std::exchange(done->next, w.steps()) == w.steps()) return;
      auto& s = detail::state_of(w);
      s.each_finite_shape([&](auto& b) {
        auto& store = b.movable;
        for (std::size_t i = 0; i < store.size(); ++i) {  // shadow copies too, as their owners do
          if (store.inverse_mass[i] == 0) continue;
          const vec3 a = f(store.position[i], s.time);
          if (!detail::finite(a))
            detail::fail<std::runtime_error>(
                "the force field is {} at {}, where body {} is at time {}: it must be finite", a,
                store.position[i], store.id[i], s.time);
          store.force[i] += a / store.inverse_mass[i];
        }
      });
    };
    if constexpr (scenario::template has_feature<checkpoints>) w.keep(name, done->next);
    w.before_simulating(name, act);
    w.after_each_step(name, act);
    w.note_force(name);
  }
}

}  // namespace talus
