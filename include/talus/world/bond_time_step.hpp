#pragma once
// The longest time step that is stable for the bonds of a world.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/type_list.hpp"
#include "talus/interaction/parallel_bond.hpp"
#include "talus/interaction/soft_state.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/step/soft_step.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Whether parallel_bond is a part of the contact law of a scenario.
template <class Scenario>
inline constexpr bool has_bonds = [] {
  if constexpr (Scenario::contact_law::soft)
    return contains_type<typename Scenario::contact_law::list, parallel_bond>;
  else
    return false;
}();

/// The stiffness of all bonds of a body against its own displacement and rotation.
struct bonds_of_body {
  static constexpr std::size_t n = 6;
  std::array<real, n * n> stiffness{};
  real count = 0, damping_ratio = 0;

  /// Adds a bond along `normal`, at whose middle the surface of the body has this arm.
  void add(const parallel_bond::stiffnesses& k, real damping, const vec3& normal, const vec3& arm) {
    const real square = arm.squaredNorm();
    const auto at = [&](std::size_t i, std::size_t j) -> real& { return stiffness[i * n + j]; };
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        const real along = normal[i] * normal[j], across = (i == j) - along;
        at(i, j) += k.stretch * along + k.shear * across;
        at(3 + i, 3 + j) += k.twist * along + (k.bend + k.shear * square) * across;
      }
    // Slip is u + theta x arm.
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
      at(i, 3 + j) += k.shear * arm[l], at(3 + j, i) += k.shear * arm[l];
      at(i, 3 + l) -= k.shear * arm[j], at(3 + l, i) -= k.shear * arm[j];
    }
    count += 1, damping_ratio = std::max(damping_ratio, damping);
  }
  /// A bound of the stable step: the square of no frequency exceeds twice the largest eigenvalue
  /// for this body alone. That is at most the trace of the 32nd power, to the 1/32: at most 6 %
  /// more.
  [[nodiscard]] real longest_step(real mass, real inertia) const {
    if (!(count > 0)) return std::numeric_limits<real>::infinity();
    std::array<real, n* n> a = stiffness;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        a[i * n + j] /= std::sqrt((i < 3 ? mass : inertia) * (j < 3 ? mass : inertia));
    real bound = 1, share = 1;
    const auto trace = [&] {
      real sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += a[i * n + i];
      return sum;
    };
    for (int power = 0; power < 5; ++power) {
      const real size = trace();
      for (real& x : a) x /= size;
      bound *= portable::pow(size, share), share /= 2;
      std::array<real, n * n> square{};
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t l = 0; l < n; ++l)
          for (std::size_t j = 0; j < n; ++j) square[i * n + j] += a[i * n + l] * a[l * n + j];
      a = square;
    }
    bound *= portable::pow(trace(), share);
    const real z = std::sqrt(count) * damping_ratio;
    return 2 * (std::sqrt(1 + z * z) - z) / std::sqrt(2 * bound);
  }
};

/// Collective: the longest time step that is stable for the bonds that hold; infinite if there are
/// none. A body that is not a sphere counts as one of its volume.
template <class Scenario>
[[nodiscard, gnu::cold]] real longest_step_of_bonds(world<Scenario>& w) {
  using law = typename Scenario::contact_law::law;
  auto& s = state_of(w);
  s.soft.pairs.follow(s.materials);
  const body_places<Scenario> places(s);
  std::vector<bonds_of_body> bonds(places.size());
  struct end {
    material_id material{};
    real radius = 0;
  };
  const auto look = [&](const contact_key& key, const contact_geometry& g, const vec3&, bool) {
    const auto* all = s.history.find(key);
    if (all == nullptr) return;
    const auto& m = law::template of<parallel_bond>(*all);
    if (m.radius == 0) return;
    const auto end_of = [&](system_id id) {
      end e;
      places.visit(id, [&](const auto& store, std::size_t i, bool) {
        e.material = store.material[i];
        if constexpr (std::remove_cvref_t<decltype(store)>::shape_type::finite)
          e.radius = sphere_radius(store.shape[i]);
      });
      return e;
    };
    const end a = end_of(key.a), b = end_of(key.b);
    const auto& p = law::template of<parallel_bond>(s.soft.pairs.pair(a.material, b.material));
    const parallel_bond::stiffnesses k = parallel_bond::stiffness(p, m);
    const auto add = [&](system_id id, const vec3& arm) {
      bonds[places.number_of(id)].add(k, p.damping_ratio, g.normal, arm);
    };
    add(key.a, -(a.radius + m.gap / 2) * g.normal), add(key.b, (b.radius + m.gap / 2) * g.normal);
  };
  observe_contacts(s, look);
  real least = std::numeric_limits<real>::infinity();
  for (std::size_t k = 0; k < bonds.size(); ++k)
    places.visit_number(k, [&](const auto& store, std::size_t i, bool global) {
      if constexpr (std::remove_cvref_t<decltype(store)>::shape_type::finite) {
        if (global || i >= store.locals || store.fixed(i)) return;
        const real r = sphere_radius(store.shape[i]), mass = 1 / store.inverse_mass[i];
        least = std::min(least, bonds[k].longest_step(mass, real(0.4) * mass * r * r));
      }
    });
  s.link->reduce(reduction::min, std::span(&least, 1));
  return least;
}

}  // namespace talus::detail
