#pragma once
// The contact residual of the step that has just been made.
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "talus/response/residual.hpp"
#include "talus/world/state.hpp"
#include "talus/world/unbalanced_force.hpp"

namespace talus {

/// The contact residual, without dimension: |r - P_K(r - rho u^)| / max(|r|, rho |q|, rho |u|), the
/// natural map of the frictional contact problem in De Saxce's form (Acary, Bremond, Huber 2018).
/// r are the impulses, u = W r + q the relative velocities less what gaps and restitution ask for,
/// u^ = u + mu |u_t| n, K the Coulomb cones, rho = 1 / mean diagonal of W.
///
/// Of soft contacts, which have no problem to solve, the ratio of unbalanced force (Cundall): the
/// root mean square of the resultant of contact forces and weight over the bodies that touch
/// something, over the root mean square of the contact forces. It tends to 0 as bodies come to
/// rest, and is of the order of 1 where they collide.
struct contact_residual {
  double value = 0;  ///< of all contacts; 0 where nothing touches
  /// Of the worst contact, over the root mean square of the scale: `value` is the root mean square
  /// of such values. Of soft contacts: of the worst body.
  double max = 0;
  std::uint64_t contacts = 0;
};

namespace detail {

/// Gives shadow copies what their owners have, in two solver states of the last step.
template <class Scenario, class Real>
void refresh_last_step(world_state<Scenario>& s, solver_state_of<Real>& x,
                       solver_state_of<Real>& y) {
  using vector = vector3<Real>;
  constexpr std::size_t bytes = 4 * sizeof(vector);
  const auto each = [&](std::uint32_t i, auto&& f) {
    f(x.bodies[i].v), f(x.bodies[i].w), f(y.bodies[i].v), f(y.bodies[i].w);
  };
  std::vector<parcel> parcels;
  for (const auto& other : s.travelled) {
    parcel& p = parcels.emplace_back(parcel{.rank = other.rank});
    p.out.resize(other.sent.size() * bytes);
    p.in.resize(other.received.size() * bytes);
    std::byte* to = p.out.data();
    for (const auto i : other.sent)
      each(i, [&](const vector& v) { std::memcpy(to, v.data(), sizeof v), to += sizeof v; });
  }
  s.link->start_fixed(parcels);
  s.link->finish_fixed(parcels);
  for (std::size_t n = 0; n < parcels.size(); ++n) {
    const std::byte* from = parcels[n].in.data();
    for (const auto i : s.travelled[n].received)
      each(i, [&](vector& v) { std::memcpy(v.data(), from, sizeof v), from += sizeof v; });
  }
}

/// Collective. The solver's arrays and the lists of what travelled stay as the last step left them
/// until the next one begins, whatever happens to bodies and connections in between.
template <class Scenario>
contact_residual last_hard_residual(world_state<Scenario>& s) {
  // Velocities at the end, and what the impulses gave to them: u and W r are read from these.
  auto after = s.solver, given = s.solver;
  for (auto& body : given.bodies) body.v = body.w = {0, 0, 0};
  s.each_contact_list([&](const auto& list) {
    if constexpr (requires { list.warm_start(given); }) list.warm_start(given);
  });
  if constexpr (!world_state<Scenario>::link_type::alone) refresh_last_step(s, after, given);

  residual_scale scale;
  each_of(s.contacts, [&](const auto& list) { list.add_to(scale, after, given); });
  s.link->reduce(reduction::sum, scale.sums);
  residual_sums sums = sums_of(s.contacts, after, scale.rho());
  s.link->reduce(reduction::sum, sums.sums);
  s.link->reduce(reduction::max, std::span(&sums.largest, 1));

  const contact_residual r{sums.value(scale), sums.worst(scale),
                           static_cast<std::uint64_t>(sums.sums[3])};
  s.convergence.add_residual(r.value);
  return r;
}

/// Collective: the residual of the last step, which is also noted in the world's convergence.
template <class Scenario>
contact_residual last_residual(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::law::soft) {
    const unbalanced_sums u = measure_unbalanced_force(s);
    s.convergence.add_residual(u.value());
    return {u.value(), u.worst(), static_cast<std::uint64_t>(u.sums[3])};
  } else {
    return last_hard_residual(s);
  }
}

}  // namespace detail
}  // namespace talus
