#pragma once
// The contact residual of the last step.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "talus/constraint/residual.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/state/state.hpp"
#include "talus/step/unbalanced_force.hpp"

namespace talus {

/// The contact residual, dimensionless: |r - P_K(r - rho u^)| / max(|r|, rho |q|, rho |u|), the
/// natural map of the frictional contact problem in De Saxce's form (Acary, Bremond, Huber 2018). r
/// are the impulses, u = W r + q the relative velocities minus the targets from gaps and
/// restitution, u^ = u + mu |u_t| n, K the Coulomb cones, rho = 1 / mean diagonal of W.
///
/// For soft contacts, which pose no such problem, the ratio of unbalanced force (Cundall): the root
/// mean square of the resultant of contact forces and weight over the bodies that touch something,
/// over the root mean square of the contact forces. It tends to 0 as bodies come to rest, and is of
/// the order of 1 where they collide.
struct contact_residual {
  double value = 0;  ///< of all contacts; 0 without contacts
  /// The residual of the worst contact over the root mean square of the scale; `value` is the root
  /// mean square of such residuals. For soft contacts, that of the worst body.
  double max = 0;
  std::uint64_t contacts = 0;
};

namespace detail {

/// Copies the values of the owners to shadow copies, in two solver states of the last step.
template <class Scenario, class Real>
void refresh_last_step(world_state<Scenario>& s, solver_state_of<Real>& x,
                       solver_state_of<Real>& y) {
  using vector = vector3<Real>;
  constexpr std::size_t bytes = 4 * sizeof(vector);
  const auto each = [&](std::uint32_t i, auto&& f) {
    f(x.bodies[i].v), f(x.bodies[i].w), f(y.bodies[i].v), f(y.bodies[i].w);
  };
  std::vector<neighbour_message> neighbour_messages;
  for (const auto& other : s.travelled) {
    neighbour_message& p = neighbour_messages.emplace_back(neighbour_message{.rank = other.rank});
    p.out.resize(other.sent.size() * bytes);
    p.in.resize(other.received.size() * bytes);
    std::byte* to = p.out.data();
    for (const auto i : other.sent)
      each(i, [&](const vector& v) { std::memcpy(to, v.data(), sizeof v), to += sizeof v; });
  }
  s.link->start_fixed(neighbour_messages);
  s.link->finish_fixed(neighbour_messages);
  for (std::size_t n = 0; n < neighbour_messages.size(); ++n) {
    const std::byte* from = neighbour_messages[n].in.data();
    for (const auto i : s.travelled[n].received)
      each(i, [&](vector& v) { std::memcpy(v.data(), from, sizeof v), from += sizeof v; });
  }
}

/// Collective. The solver's arrays and the lists of exchanged velocities keep the state of the last
/// step until the next one begins, whatever happens to bodies and connections in between.
template <class Scenario>
contact_residual last_hard_residual(world_state<Scenario>& s) {
  // Velocities at the end, and the part of them from impulses: u and W r are computed from these.
  auto after = s.solver, given = s.solver;
  for (auto& body : given.bodies) body.v = body.w = {0, 0, 0};
  s.each_constraint_list([&](const auto& list) {
    if constexpr (requires { list.warm_start(given); }) list.warm_start(given);
  });
  if constexpr (!world_state<Scenario>::link_type::alone) refresh_last_step(s, after, given);

  residual_scale_of<exact_sum> scale;
  s.each_constraint_list([&](const auto& list) { list.add_to(scale, after, given); });
  sum_exactly(*s.link, scale.sums);
  residual_sums_of<exact_sum> sums;
  s.each_constraint_list([&](const auto& list) { list.add_to(sums, after, scale.rho()); });
  sum_exactly(*s.link, sums.sums);
  s.link->reduce(reduction::max, std::span(&sums.largest, 1));

  const contact_residual r{sums.value(scale), sums.worst(scale),
                           static_cast<std::uint64_t>(sums.sums[3].value())};
  s.convergence.add_residual(r.value);
  return r;
}

/// Collective: the residual of the last step, also recorded in the world's convergence; that of
/// soft contacts is of the present state, and residual_monitor records that of the step.
template <class Scenario>
contact_residual last_residual(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::law::soft) {
    const unbalanced_sums u = measure_unbalanced_force(s);
    if constexpr (!monitored<Scenario, residual_monitor>) s.convergence.add_residual(u.value());
    return {u.value(), u.worst(), static_cast<std::uint64_t>(u.sums[3].value())};
  } else {
    return last_hard_residual(s);
  }
}

}  // namespace detail
}  // namespace talus
