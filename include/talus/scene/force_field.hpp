#pragma once
// Accelerations that depend on place and time: gravity of a centre, a wind, a vibrating frame.
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/world/scenario.hpp"

namespace talus {

/// All bodies that can move are accelerated by f(position of the centre, time), beside gravity, in
/// the steps of simulate(): as a force of the user, for each step by its value at the start.
/// Nothing travels between ranks for it: f must give the same bits on all of them. Bodies that
/// sleep go on sleeping. What is added after a step by an observer that runs later than this one
/// feels it from the next but one on. `name` is that of its state in checkpoints, one for each. All
/// ranks call it alike. Throws runtime_error where f is not finite. Needs features<forces>.
template <class World, class F>
void add_force_field(World& w, F f, const std::string& name = "force field") {
  using scenario = typename World::scenario_type;
  if constexpr (detail::require_feature<scenario, forces>()) {
    w.require_all_ranks("add_force_field");
    struct record {
      std::uint64_t next = ~std::uint64_t{0};  ///< the step for which forces have been added
    };
    const auto done = std::make_shared<record>();
    const auto act = [&w, f = std::move(f), done] {
      if (std::exchange(done->next, w.steps()) == w.steps()) return;
      auto& s = w.state();
      s.each_finite_shape([&](auto& b) {
        auto& store = b.movable;
        for (std::size_t i = 0; i < store.size(); ++i) {  // shadow copies too, as their owners do
          if (!store.moves(i)) continue;
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
    w.before_simulating(act);
    w.after_each_step(act);
  }
}

}  // namespace talus
