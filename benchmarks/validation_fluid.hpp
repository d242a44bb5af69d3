#pragma once
/// \file
/// Drag and buoyancy of a given fluid: terminal velocities, relaxation, a neutral body.
#include <cmath>
#include <string>
#include <talus/parallel/serial.hpp>
#include <talus/scene/fluid.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

#include "validation.hpp"

namespace validation {

namespace fluid_cases {

using scene = talus::scenario<talus::bodies<talus::sphere>, talus::transport<talus::serial>,
                              talus::features<talus::forces>>;

/// Velocity, downwards, of a sphere that has fallen from rest for some steps.
template <class Fluid, class Law>
double fall(double diameter, double density, const Fluid& of, Law law, double dt, int steps) {
  talus::serial::link link;
  talus::world<scene> w(link);
  w.material({.density = density});
  w.gravity({0, 0, -9.81});
  const auto ball = w.add(talus::body{.shape = talus::sphere{diameter / 2}});
  talus::add_fluid(w, of, law);
  w.simulate({.steps = static_cast<std::uint64_t>(steps), .dt = dt});
  return -w[ball].velocity()[2];
}

/// The velocity at which a drag coefficient of the Reynolds number balances the weight in the
/// fluid, by bisection.
template <class Coefficient>
double terminal(double diameter, double excess, double rho, double mu, Coefficient coefficient) {
  double low = 0, high = 100;
  for (int k = 0; k < 200; ++k) {
    const double v = (low + high) / 2, re = rho * v * diameter / mu;
    const double drag = 0.125 * rho * talus::pi * diameter * diameter * v * v * coefficient(re);
    const double weight = excess * talus::pi / 6 * std::pow(diameter, 3) * 9.81;
    (drag > weight ? high : low) = v;
  }
  return low;
}

}  // namespace fluid_cases

inline void fluid(report& out, const effort&) {
  using namespace talus;
  using fluid_cases::fall;
  const double rho = 998.2, mu = 1.002e-3, density = 2500;
  const talus::fluid water{.density = rho, .viscosity = mu};
  const auto add = [&](const std::string& what, double expected, double found, double relative,
                       const std::string& source) {
    out.push_back(
        {"fluid/" + what, "velocity", "m/s", expected, found, relative * expected, source});
  };
  {
    const double d = 2e-5, v = (density - rho) * 9.81 * d * d / (18 * mu);
    const double tau = density * d * d / (18 * mu);
    add("Stokes/terminal, glass of 20 um in water", v,
        fall(d, density, water, stokes_drag{}, tau, 100), 1e-9,
        "Stokes 1851: (rho_s - rho) g d^2 / (18 mu)");
    add("Stokes/after one relaxation time", v * (1 - std::exp(-1.0)),
        fall(d, density, water, stokes_drag{}, tau / 50, 50), 1e-9, "1 - exp(-t / tau)");
  }
  for (const double d : {1e-4, 1e-3, 5e-3}) {
    char size[64];
    std::snprintf(size, sizeof size, "terminal, glass of %g mm in water", 1e3 * d);
    add(std::string("Schiller and Naumann/") + size,
        fluid_cases::terminal(d, density - rho, rho, mu,
                              [](double re) {
                                return re < 1000 ? 24 / re * (1 + 0.15 * std::pow(re, 0.687))
                                                 : 0.44;
                              }),
        fall(d, density, water, schiller_naumann_drag{}, 1e-3, 5000), 1e-6,
        "Schiller, Naumann 1933");
    for (const double free : {1.0, 0.6}) {
      const talus::fluid around{.density = rho, .viscosity = mu, .void_fraction = free};
      add(std::string("Di Felice/void fraction ") + (free == 1 ? "1, " : "0.6, ") + size,
          fluid_cases::terminal(d, density - rho, rho, mu,
                                [free](double alone) {
                                  const double re = free * alone, x = 1.5 - std::log10(re);
                                  const double chi = 3.7 - 0.65 * std::exp(-0.5 * x * x);
                                  return std::pow(0.63 + 4.8 / std::sqrt(re), 2) *
                                         std::pow(free, 2 - chi);
                                }),
          fall(d, density, around, di_felice_drag{}, 1e-3, 5000), 1e-6, "Di Felice 1994");
    }
  }
  const double rise = fall(1e-2, 500, talus::fluid{.density = 1000}, no_drag{}, 1e-3, 100);
  out.push_back({"fluid/buoyancy alone, half the density of the fluid", "velocity", "m/s",
                 -9.81 * 0.1, rise, 1e-12, "Archimedes: (rho / rho_s - 1) g t"});
}

}  // namespace validation
