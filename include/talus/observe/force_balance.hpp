#pragma once
// Errors that the contact residual does not show: the support of the weight, and bodies that
// penetrate others that should stop them. Measured on request, from the data of the last step.
#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "talus/constraint/contact_work.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/features/momentum_balance.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/step/last_residual.hpp"
#include "talus/world/fresh_start.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The balance of momentum of the last step, over the impulse of the weight of all bodies that can
/// move in it; without gravity all is 0. Of soft contacts only `borne`, for the present state.
struct force_balance {
  bool known = false;    ///< a step was made, there is gravity, and no body sleeps
  double borne = 0;      ///< given by fixed bodies, against gravity: 1 at rest
  double change = 0;     ///< momentum gained by gravity and contacts together, against gravity
  double error = 0;      ///< impulse of contacts on the bodies, minus the impulse from fixed bodies
  double unstopped = 0;  ///< momentum of bodies into bodies that they touch
};

namespace detail {

/// Sums of one rank: mass, impulse of contacts on own bodies, impulse from fixed ones, and the
/// momentum that they did not stop.
struct balance_sums {
  exact_sum mass, unstopped;
  vector_sum given, ground;
};

/// Collective, as neighbours exchange velocities. The contact lists and the solver's arrays are
/// those of the last step.
template <class Scenario>
[[nodiscard, gnu::cold]] balance_sums hard_balance(world_state<Scenario>& s) {
  auto after = s.solver, given = s.solver;
  for (auto& body : given.bodies) body.v = body.w = {0, 0, 0};
  s.each_constraint_list([&](const auto& list) {
    if constexpr (requires { list.warm_start(given); }) list.warm_start(given);
  });
  if constexpr (!world_state<Scenario>::link_type::alone) refresh_last_step(s, after, given);
  plain_vector<real> speeds;
  speeds.assign(after.bodies.size(), 0);
  s.each_contact_list([&](const auto& list) { list.add_approach(after, speeds); });
  balance_sums sums;
  add_impulse_of_ground(s, sums.ground);
  // The solver's arrays show which bodies were owned here in that step: those that no message
  // updated.
  plain_vector<char> foreign;
  foreign.assign(after.bodies.size(), 0);
  for (const auto& other : s.travelled)
    for (const auto k : other.received) foreign[k] = 1;
  const std::size_t end = std::min<std::size_t>(after.bodies.size(), after.first_global);
  for (std::size_t k = 0; k < end; ++k) {
    const real inverse = after.bodies[k].inverse_mass;
    if (inverse == 0 || foreign[k] != 0) continue;
    sums.mass += 1 / inverse;
    sums.given += vec3(in_scalar<real>(given.bodies[k].v) / inverse);
    sums.unstopped += speeds[k] / inverse;
  }
  return sums;
}

/// The force of contacts on all bodies that can move, in the present state: internal forces cancel.
template <class Scenario>
[[nodiscard, gnu::cold]] balance_sums soft_balance(world<Scenario>& w) {
  auto& s = state_of(w);
  balance_sums sums;
  id_table own;
  std::size_t all = 0;
  w.for_each_local([&](const auto&) { ++all; });
  own.reset(all);
  w.for_each_local([&](const auto& b) {
    if (b.is_fixed()) return;
    own.add(b.id());
    sums.mass += b.mass();
  });
  observe_forces(s, [&](const contact_key& key, const vec3& force, bool on_a, bool on_b) {
    if (on_a && own.has(key.a)) sums.ground += vec3(s.dt * force);
    if (on_b && own.has(key.b)) sums.ground -= vec3(s.dt * force);
  });
  sums.given = sums.ground;
  return sums;
}

}  // namespace detail

/// Collective: the momentum balance of the last step. Costs about as much as measure_residual;
/// steps have no extra cost.
template <class Scenario>
[[nodiscard, gnu::cold]] force_balance measure_force_balance(world<Scenario>& w) {
  w.require_all_ranks("measure_force_balance");
  auto& s = detail::state_of(w);
  force_balance b;
  double asleep = 0;
  if constexpr (detail::world_state<Scenario>::sleeps)
    w.for_each_local([&](const auto& body) { asleep += body.is_asleep(); });
  w.link().reduce(reduction::sum, std::span(&asleep, 1));
  const double g = s.gravity.norm();
  if (!(g > 0) || !(s.dt > 0) || w.steps() <= w.restarted_at() || asleep > 0) return b;
  detail::balance_sums sums;
  if constexpr (Scenario::contact_law::soft)
    sums = detail::soft_balance(w);
  else
    sums = detail::hard_balance(s);
  detail::sum_exactly(w.link(), sums.mass, sums.unstopped, sums.given, sums.ground);
  const double weight = sums.mass.value() * g * s.dt;
  if (!(weight > 0)) return b;
  const vec3 given = sums.given.value(), ground = sums.ground.value(), up = -s.gravity / g;
  b.known = true;
  b.borne = ground.dot(up) / weight;
  b.change = given.dot(up) / weight - 1;
  b.error = (given - ground).norm() / weight;
  b.unstopped = sums.unstopped.value() / weight;
  return b;
}

}  // namespace talus
