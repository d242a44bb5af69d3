#pragma once
// Making and observing the bonds of a world with the law parallel_bond.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/random.hpp"
#include "talus/interaction/parallel_bond.hpp"
#include "talus/step/soft_step.hpp"
#include "talus/world/bond_time_step.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// A bond, or the remains of one while its bodies are within range.
struct bond_view {
  system_id a = no_id, b = no_id;
  vec3 point{0, 0, 0};                   ///< midway between the surfaces
  vec3 normal{0, 0, 1};                  ///< unit, from b towards a
  bond_break broken = bond_break::none;  ///< how it has broken
  parallel_bond::stresses stress{};      ///< of a bond that holds
};

/// Bonds over all ranks; alike on all of them.
struct bond_count {
  std::uint64_t intact = 0;                         ///< that hold
  std::uint64_t tension = 0, shear = 0, range = 0;  ///< broken so, the bodies still within range
};

namespace detail {

/// False after a refusal, so that `if constexpr (require_bond_law<Scenario>())` suppresses further
/// errors.
template <class Scenario>
consteval bool require_bond_law() {
  static_assert(has_bonds<Scenario>,
                "bonds need the law parallel_bond: add it to soft_contact<...> of the scenario");
  return has_bonds<Scenario>;
}

/// A random factor of the strength of a bond, the same on any rank, from a Weibull
/// distribution of scale 1.
[[nodiscard]] inline real weakening_of(const parallel_bond::parameters& p, system_id a,
                                       system_id b) {
  if (!(p.weibull_modulus > 0)) return 1;
  const std::uint64_t first = std::min(value_of(a), value_of(b)),
                      second = std::max(value_of(a), value_of(b));
  random_stream random(p.seed, mix(first) ^ (second * 0x9e3779b97f4a7c15ull));
  return portable::pow(-portable::log(1 - random.uniform()), 1 / p.weibull_modulus);
}

inline void require_bond_parameters(const parallel_bond::parameters& p, real gap, system_id a,
                                    system_id b) {
  if (!(gap < real(0.98) * p.range))
    fail<std::invalid_argument>(
        "a bond of {} and {} at a gap of {} would break at once, because the range of "
        "parallel_bond is {}: give parallel_bond::parameters a longer range",
        value_of(a), value_of(b), gap, p.range);
}

/// Collective: bonds the pairs for which wanted(a, b, gap) is true and that have none, if the
/// parameters of their materials have a modulus.
template <class Scenario, class Wanted>
std::uint64_t make_bonds(world<Scenario>& w, Wanted&& wanted) {
  using law = typename Scenario::contact_law::law;
  w.synchronize();
  auto& s = state_of(w);
  s.soft.pairs.follow(s.materials);
  const body_places<Scenario> places(s);
  struct found {
    contact_key key;
    parallel_bond::memory beam;
    bool counts;
  };
  std::vector<found> made;
  const auto consider = [&](const contact_key& key, const contact_geometry& g, const vec3&,
                            bool counts) {
    if (!wanted(key.a, key.b, g.gap)) return;
    if (const auto* old = s.history.find(key))
      if (law::template of<parallel_bond>(*old).radius > 0) return;
    real ra = 0, rb = 0;
    material_id ma{}, mb{};
    const auto look = [&](system_id id, real& r, material_id& m) {
      places.visit(id, [&](const auto& store, std::size_t i, bool) {
        m = store.material[i];
        if constexpr (std::remove_cvref_t<decltype(store)>::shape_type::finite)
          r = sphere_radius(store.shape[i]);
      });
    };
    look(key.a, ra, ma), look(key.b, rb, mb);
    if (rb == 0) rb = ra;  // an infinite body
    const auto& p = law::template of<parallel_bond>(s.soft.pairs.pair(ma, mb));
    if (!(p.youngs_modulus > 0)) return;
    require_bond_parameters(p, g.gap, key.a, key.b);
    parallel_bond::memory beam;
    beam.radius = p.radius_multiplier * std::min(ra, rb);
    beam.gap = g.gap, beam.length = ra + rb + g.gap;
    beam.weakening = weakening_of(p, key.a, key.b);
    made.push_back({key, beam, counts});
  };
  observe_contacts(s, consider);
  auto old = std::move(s.history);
  s.history = {};
  s.history.reset(old.entries().size() + made.size());
  s.found.forget_places();
  std::uint64_t count = 0;
  for (const found& f : made) {
    typename world_state<Scenario>::history_type::memory m{};
    if (const auto* kept = old.find(f.key)) m = *kept;
    law::template of<parallel_bond>(m) = f.beam;
    s.history.add(f.key, m);
    count += f.counts;
  }
  for (const auto& e : old.entries())
    if (s.history.find(e.key) == nullptr) s.history.add(e.key, e.memory);
  std::uint64_t sum[1] = {count};
  s.link->reduce(reduction::sum, std::span(sum));
  s.soft.step_of_bonds = std::min(s.soft.step_of_bonds, longest_step_of_bonds(w));
  return sum[0];
}

/// Throws invalid_argument for a distance of bonds beyond the range of the law for all pairs.
template <class Scenario>
void require_bond_distance(world<Scenario>& w, real distance) {
  real furthest = 0;
  for (const auto& e : state_of(w).soft.pairs.template given<parallel_bond>().entries())
    if (e.value.youngs_modulus > 0) furthest = std::max(furthest, e.value.range);
  if (!(distance < real(0.98) * furthest))
    fail<std::invalid_argument>(
        "bond_within(world, {}) reaches beyond the range of parallel_bond, {}, where bonds break: "
        "give parallel_bond::parameters a longer range, or a shorter distance",
        distance, furthest);
}

}  // namespace detail

/// Collective: bonds all pairs of bodies whose surfaces are at most `distance` apart at this
/// moment, as those of a lattice, and whose parameters have a modulus. Returns the number of new
/// bonds over all ranks. Pairs that have a bond keep it. Throws invalid_argument for a distance
/// beyond the range of the law.
template <class Scenario>
std::uint64_t bond_within(world<Scenario>& w, real distance) {
  if constexpr (detail::require_bond_law<Scenario>()) {
    detail::require_bond_distance(w, distance);
    return detail::make_bonds(w, [&](system_id, system_id, real gap) { return gap <= distance; });
  } else {
    return 0;
  }
}

/// Collective: bonds the pairs of a list, which is alike on all ranks. Returns the number of new
/// bonds. Throws invalid_argument, on all ranks, if a pair does not exist, is farther apart than
/// the range of the law, has no modulus or a bond already, or is listed twice.
template <class Scenario>
std::uint64_t bond_pairs(world<Scenario>& w,
                         std::span<const std::pair<system_id, system_id>> list) {
  if constexpr (detail::require_bond_law<Scenario>()) {
    std::set<std::pair<std::uint64_t, std::uint64_t>> wanted;
    for (const auto& [a, b] : list) wanted.insert(std::minmax({value_of(a), value_of(b)}));
    const std::uint64_t made = detail::make_bonds(w, [&](system_id a, system_id b, real) {
      return wanted.count(std::minmax({value_of(a), value_of(b)})) > 0;
    });
    if (made != list.size())
      detail::fail<std::invalid_argument>(
          "bond_pairs bonded {} of {} pairs: list each pair once, of bodies without a bond whose "
          "surfaces are within the range of parallel_bond and whose materials have its parameters",
          made, list.size());
    return made;
  } else {
    return 0;
  }
}

/// Calls f(bond_view) for the bonds of the present state, and for broken ones whose bodies are
/// within range: over all ranks once for each. No rank waits for another.
template <class Scenario, class F>
void for_each_bond(world<Scenario>& w, F&& f) {
  if constexpr (detail::require_bond_law<Scenario>()) {
    w.note_reading("for_each_bond");
    using law = typename Scenario::contact_law::law;
    auto& s = detail::state_of(w);
    const detail::body_places<Scenario> places(s);
    const auto look = [&](const detail::contact_key& key, const contact_geometry& g, const vec3&,
                          bool counts) {
      if (!counts) return;
      const auto* all = s.history.find(key);
      if (all == nullptr) return;
      const auto& m = law::template of<parallel_bond>(*all);
      if (m.radius == 0 && m.broken == bond_break::none) return;
      bond_view b{.a = key.a, .b = key.b, .point = g.point, .normal = g.normal, .broken = m.broken};
      material_id ma{}, mb{};
      places.visit(key.a, [&](const auto& x, std::size_t i, bool) { ma = x.material[i]; });
      places.visit(key.b, [&](const auto& x, std::size_t i, bool) { mb = x.material[i]; });
      b.stress = parallel_bond::stress(
          {.gap = g.gap}, law::template of<parallel_bond>(s.soft.pairs.pair(ma, mb)), m);
      f(std::as_const(b));
    };
    detail::observe_contacts(s, look);
  }
}

/// Collective: the number of bonds of the world.
template <class Scenario>
[[nodiscard]] bond_count count_bonds(world<Scenario>& w) {
  std::uint64_t n[4] = {0, 0, 0, 0};
  for_each_bond(w, [&](const bond_view& b) { ++n[static_cast<std::size_t>(b.broken)]; });
  detail::state_of(w).link->reduce(reduction::sum, std::span(n));
  return {n[0], n[1], n[2], n[3]};
}

}  // namespace talus
