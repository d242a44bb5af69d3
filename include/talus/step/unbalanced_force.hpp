#pragma once
// The residual of soft contacts: the deviation of the bodies from force balance.
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <tuple>

#include "talus/contact/key.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/id_table.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/state/state.hpp"
#include "talus/step/soft_step.hpp"

namespace talus::detail {

/// The forces of the present state, on the bodies owned here.
struct unbalanced_sums {
  std::array<exact_sum, 4> sums{};  ///< |resultant|^2, bodies, |contact force|^2, contacts
  double largest = 0;               ///< of the squares of the resultants

  [[nodiscard]] double scale() const {
    const double all = sums[2], contacts = sums[3];
    return contacts > 0 ? std::sqrt(all / contacts) : 0;  // the typical contact force
  }
  [[nodiscard]] double value() const {
    const double all = sums[0], bodies = sums[1], of_contacts = scale();
    return of_contacts > 0 ? std::sqrt(all / bodies) / of_contacts : 0;
  }
  [[nodiscard]] double worst() const {
    const double of_contacts = scale();
    return of_contacts > 0 ? std::sqrt(largest) / of_contacts : 0;
  }
};

/// Adds the resultant of the contact forces on one body and of its weight.
inline void add_resultant(unbalanced_sums& u, const vec3& resultant) {
  const double square = resultant.squaredNorm();
  u.sums[0] += square;
  u.sums[1] += 1;
  if (!(square <= u.largest)) u.largest = square;  // keeps a NaN
}
/// Collective: those of all ranks.
template <class Scenario>
void add_up_over_ranks(world_state<Scenario>& s, unbalanced_sums& u) {
  sum_exactly(*s.link, u.sums);
  s.link->reduce(reduction::max, std::span(&u.largest, 1));
}

/// Collective: of the forces that measure_forces() has just added up. Each rank computes all
/// contacts of the bodies that it owns.
template <class Scenario>
[[nodiscard]] unbalanced_sums unbalanced_force_of_step(world_state<Scenario>& s) {
  unbalanced_sums u;
  u.sums[2] = s.soft.squares_of_forces;
  u.sums[3] += static_cast<double>(std::get<soft_contacts>(s.contacts).here);
  s.each_finite_shape([&](const auto& b) {
    const soft_body* const bodies = s.soft.bodies.data() + b.first;
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      if (bodies[i].contacts != 0 && bodies[i].inverse_mass != 0)
        add_resultant(u, bodies[i].force + (1 / bodies[i].inverse_mass) * s.gravity);
  });
  add_up_over_ranks(s, u);
  return u;
}

/// Collective: adds up the contact forces of the present state on each movable body in contact, and
/// gravity. The user's forces of the step are already applied, and are excluded.
template <class Scenario>
[[nodiscard]] unbalanced_sums measure_unbalanced_force(world_state<Scenario>& s) {
  unbalanced_sums u;
  struct load {
    system_id id = no_id;
    double mass = 0;
    bool touches = false;
    vec3 force{0, 0, 0};
    [[nodiscard]] bool operator<(const load& other) const { return id < other.id; }
  };
  plain_vector<load> loads;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      if (const double inverse = b.movable.inverse_mass[i]; inverse != 0)
        loads.push_back({.id = b.movable.id[i], .mass = 1 / inverse});
  });
  sort_values(loads);
  const id_table places(loads, [](const load& l) { return l.id; });
  const auto add = [&](system_id id, const vec3& force) {
    const auto at = places.find(id);
    if (at == id_table::unknown) return false;
    loads[at].touches = true;
    loads[at].force += force;
    return true;
  };
  observe_forces(s, [&](const contact_key& key, const vec3& force, bool on_a, bool on_b) {
    if (world_state<Scenario>::law::law::reaches && force == vec3(0, 0, 0)) return;
    const bool own_a = on_a && add(key.a, force), own_b = on_b && add(key.b, -force);
    if (!own_a && !own_b) return;  // a shadow copy on what cannot move, which its owner counts
    const double part = 0.5 * (on_a + on_b);  // each of its two ranks counts a half
    u.sums[2] += part * force.squaredNorm();
    u.sums[3] += part;
  });
  for (const load& l : loads)
    if (l.touches) add_resultant(u, l.force + l.mass * s.gravity);
  add_up_over_ranks(s, u);
  return u;
}

}  // namespace talus::detail
