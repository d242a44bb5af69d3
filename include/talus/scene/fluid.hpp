#pragma once
// Drag and buoyancy of bodies in a fluid whose flow is given: one-way coupling.
#include <cmath>
#include <concepts>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/scenario/scenario.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

/// No drag: the fluid acts by buoyancy alone.
struct no_drag {
  [[nodiscard]] static real factor(real, real) { return 0; }
};
/// Stokes (1851): the drag 3 pi mu d w, for Reynolds numbers below about 0.1.
struct stokes_drag {
  [[nodiscard]] static real factor(real, real) { return 1; }
};
/// Schiller & Naumann (1933): a single sphere, drag coefficient 24 / Re (1 + 0.15 Re^0.687) up to
/// Re = 1000 and 0.44 beyond.
struct schiller_naumann_drag {
  [[nodiscard]] static real factor(real reynolds, real) {
    return reynolds < 1000 ? 1 + 0.15 * portable::pow(reynolds, 0.687) : 0.44 / 24 * reynolds;
  }
};
/// Di Felice (1994), Int. J. Multiphase Flow 20, 153: a sphere among others, at any Reynolds
/// number. The drag coefficient is (0.63 + 4.8 / sqrt(Re))^2, and the void fraction e acts by e^(2
/// - chi) with chi = 3.7 - 0.65 exp(-(1.5 - log10 Re)^2 / 2).
struct di_felice_drag {
  [[nodiscard]] static real factor(real reynolds, real void_fraction) {
    const real root = 4.8 + 0.63 * std::sqrt(reynolds);
    if (void_fraction == 1) return root * root / 24;
    const real off = 1.5 - portable::log(reynolds) / 2.302585092994045684;
    const real chi = 3.7 - 0.65 * portable::exp(-0.5 * off * off);
    return root * root / 24 * portable::pow(void_fraction, 1 - chi);
  }
};

/// A drag law: `law.factor(reynolds, void_fraction)` is the drag over that of Stokes, 3 pi mu d w,
/// with the diameter d and the velocity w of the fluid relative to the body. The Reynolds number is
/// void_fraction rho d |w| / mu.
template <class Law>
concept drag_law = requires(const Law& law, real x) {
  { law.factor(x, x) } -> std::convertible_to<real>;
};

/// A fluid that fills all space. `density` in M/L^3; dynamic `viscosity` in M/(L T); `velocity` in
/// L/T, a vector or a function of position and time; `void_fraction`, the part of the volume that
/// the fluid fills, a number or a function of position and time.
template <class Velocity = vec3, class VoidFraction = real>
struct fluid {
  real density = 0;
  real viscosity = 0;
  Velocity velocity{0, 0, 0};
  VoidFraction void_fraction = 1;
};

namespace detail {

/// A value, or that of a function of position and time.
template <class Field>
[[nodiscard]] auto value_at(const Field& field, const vec3& x, real time) {
  if constexpr (std::is_invocable_v<const Field&, const vec3&, real>)
    return field(x, time);
  else
    return (void)x, (void)time, field;
}

/// (1 - exp(-x)) / x
[[nodiscard]] inline real mean_decay(real x) {
  if (x < 0.01) return 1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6))));
  return (1 - portable::exp(-x)) / x;
}

/// The diameter of the sphere of the same volume.
template <class Shape>
[[nodiscard]] real equivalent_diameter(const Shape& shape) {
  if constexpr (std::is_same_v<Shape, sphere>)
    return 2 * shape.radius;
  else
    return portable::cbrt(6 / pi * shape.volume());
}

/// The force of a fluid on body `i` of a store, constant during a step of length `dt`. It makes the
/// body relax as under gravity, buoyancy and a drag that is linear in the velocity, exactly:
/// dt may be much longer than the time of relaxation.
template <class Fluid, class Law, class Store>
[[nodiscard]] vec3 fluid_force(const Fluid& fluid, const Law& law, const Store& store,
                               std::size_t i, const vec3& gravity, real time, real dt) {
  const vec3 x = store.position[i];
  const auto& shape = store.shape[i];
  const real inverse_mass = store.inverse_mass[i];
  const vec3 buoyancy = (-fluid.density * shape.volume()) * gravity;
  const vec3 velocity = value_at(fluid.velocity, x, time);
  const real free = value_at(fluid.void_fraction, x, time);
  if (!finite(velocity))
    fail<std::runtime_error>(
        "the velocity of the fluid is {} at {}, where body {} is at time {}: it must be finite",
        velocity, x, store.id[i], time);
  if (!(free > 0 && free <= 1))
    fail<std::runtime_error>(
        "the void fraction of the fluid is {} at {}, where body {} is at time {}: it must be more "
        "than 0 and at most 1",
        free, x, store.id[i], time);
  if constexpr (std::is_same_v<Law, no_drag>) return buoyancy;
  const vec3 w = velocity - store.velocity[i];
  const real d = equivalent_diameter(shape);
  const real reynolds = free * fluid.density * d * w.norm() / fluid.viscosity;
  const real c = 3 * pi * fluid.viscosity * d * static_cast<real>(law.factor(reynolds, free));
  if (!(c >= 0 && std::isfinite(c)))
    fail<std::runtime_error>(
        "the drag law gives {} times the velocity at a Reynolds number of {} for body {}, which "
        "moves at {} in a fluid of velocity {}, at time {}: its factor must be finite and not "
        "negative",
        c, reynolds, store.id[i], store.velocity[i], velocity, time);
  const real phi = mean_decay(dt * c * inverse_mass);
  const vec3 falls = gravity + inverse_mass * buoyancy;
  return buoyancy + (c * phi) * w + ((phi - 1) / inverse_mass) * falls;
}

}  // namespace detail

/// Exerts drag and buoyancy of a fluid on all movable bodies in each step. A shape that is not a
/// sphere has the drag of a sphere of its volume; nothing acts on its rotation. The
/// buoyancy is density times volume times gravity, upwards. The flow does not feel the bodies. Each
/// step uses the fluid at its start (with integrator<moreau_midpoint> at its middle), and the
/// coefficient of the drag at the velocity there; the relaxation within the step is exact, so that
/// no dt is unstable and the terminal velocity has no error (contacts and other forces add to the
/// velocity after it). It needs no messages: functions must return the same bits on all ranks.
/// Where it changes, sleeping bodies wake. The summary gives its time under `name`. All ranks make
/// the same call. Throws invalid_argument for a density that is negative or a viscosity that is not
/// positive, and runtime_error in a step for a velocity, void fraction or drag that is not valid.
/// Needs features<forces>.
template <class World, class Velocity, class VoidFraction, class Law = di_felice_drag>
void add_fluid(World& w, fluid<Velocity, VoidFraction> of, Law law = {},
               const std::string& name = "fluid") {
  using scenario = typename World::scenario_type;
  static_assert(drag_law<Law>,
                "the drag law of add_fluid(world, fluid, law) has no function "
                "factor(reynolds, void_fraction): use stokes_drag, schiller_naumann_drag, "
                "di_felice_drag, no_drag or a type with this function");
  static_assert(
      std::is_convertible_v<Velocity, vec3> ||
          std::is_invocable_r_v<vec3, const Velocity&, const vec3&, real>,
      "the velocity of a fluid is a vec3, or a function of position and time (vec3, real) "
      "that returns one");
  static_assert(std::is_convertible_v<VoidFraction, real> ||
                    std::is_invocable_r_v<real, const VoidFraction&, const vec3&, real>,
                "the void fraction of a fluid is a number, or a function of position and time "
                "(vec3, real) that returns one");
  if constexpr (drag_law<Law> && detail::require_feature<scenario, forces>()) {
    w.require_all_ranks("add_fluid", false);
    if (!(of.density >= 0 && std::isfinite(of.density)))
      detail::fail<std::invalid_argument>(
          "the density of a fluid must be finite and not negative, but is {}", of.density);
    if constexpr (!std::is_same_v<Law, no_drag>)
      detail::require_positive(of.viscosity, "the viscosity of a fluid with drag");
    w.act_each_step(name, [&w, of = std::move(of), law = std::move(law)](real time) {
      auto& s = detail::state_of(w);
      s.each_finite_shape([&](auto& b) {
        auto& store = b.movable;
        for (std::size_t i = 0; i < store.size(); ++i)  // shadow copies too, as their owners do
          if (store.inverse_mass[i] != 0)
            store.force[i] += detail::fluid_force(of, law, store, i, s.gravity, time, s.dt);
      });
    });
  }
}

}  // namespace talus
