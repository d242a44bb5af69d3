#pragma once
// The longest time step that soft contacts allow.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "talus/parallel/reduction.hpp"
#include "talus/response/soft_pair.hpp"
#include "talus/response/soft_state.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// Longest stable step for two bodies of this mass: 2 (sqrt(1 + z^2) - z) / w with w^2 = 2 k / m
/// and the damping ratio z, from the amplification of the semi-implicit Euler method with the
/// dashpot's force at the beginning of the step; without damping also that of Verlet.
[[nodiscard]] inline real longest_step_of_spring(real stiffness, real mass, real ratio) {
  return 2 * (std::sqrt(1 + ratio * ratio) - ratio) / std::sqrt(2 * stiffness / mass);
}

/// Time that a Rayleigh wave takes along a sphere: pi R sqrt(rho / G) / (0.1631 nu + 0.8766)
/// (Thornton, Randall 1988).
[[nodiscard]] inline real rayleigh_time(real radius, const material& m) {
  const real shear = m.youngs_modulus / (2 * (1 + m.poisson_ratio));
  return pi * radius * std::sqrt(m.density / shear) / (0.1631 * m.poisson_ratio + 0.8766);
}

}  // namespace detail

/// Collective: the critical time step of a soft scenario, infinite where nothing moves. Linear
/// springs: beyond it a contact of two bodies with the smallest mass, the largest stiffness and the
/// strongest dashpot gains energy. Hertz: the shortest Rayleigh time of all bodies. Bodies with
/// many contacts are stiffer, and accuracy asks for 20 to 50 steps per contact: a fifth of it is
/// common.
template <class Scenario>
[[nodiscard]] real critical_dt(world<Scenario>& w) requires(Scenario::contact_law::soft) {
  using law = typename Scenario::contact_law;
  w.require_all_ranks("critical_dt");
  const material_table& materials = w.materials();
  real least = std::numeric_limits<real>::infinity();
  if constexpr (law::hertz) {
    w.for_each_local([&](const auto& b) {
      if (!b.is_fixed())
        least = std::min(least, detail::rayleigh_time(detail::sphere_radius(b.shape()),
                                                      materials[b.material()]));
    });
  } else {
    real stiffest = 0, damping = 0;
    for (std::size_t i = 0; i < materials.size(); ++i)
      for (std::size_t j = 0; j < materials.size(); ++j) {
        const auto a = static_cast<material_id>(i), b = static_cast<material_id>(j);
        const auto pair =
            detail::soft_pair_of<law>(materials[a], materials[b], materials.pair(a, b));
        stiffest = std::max(stiffest, pair.stiffness);
        damping = std::max(damping, pair.damping);
      }
    w.for_each_local([&](const auto& b) {
      if (!b.is_fixed())
        least = std::min(least, detail::longest_step_of_spring(stiffest, b.mass(), damping));
    });
  }
  w.link().reduce(reduction::min, std::span(&least, 1));
  return least;
}

}  // namespace talus
