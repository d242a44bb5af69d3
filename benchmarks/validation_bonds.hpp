#pragma once
/// \file
/// Bonds: stretch, torsion, the loads that break a bond, a fibre as a beam, a lattice in
/// compression.
#include <cmath>
#include <string>
#include <talus/observe/critical_dt.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/bonds.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "validation.hpp"

namespace validation {

namespace bond_cases {

using scene =
    talus::scenario<talus::bodies<talus::sphere>,
                    talus::soft_contact<talus::linear_spring_dashpot, talus::parallel_bond>,
                    talus::transport<talus::serial>,
                    talus::features<talus::forces, talus::damping>>;
using world = talus::world<scene>;
/// Cement between glass beads, in SI units.
inline constexpr double radius = 1e-3, modulus = 1e9, ratio = 0.25, density = 2500;

/// Two bonded spheres, one of them fixed.
struct pair_of_spheres {
  talus::serial::link link;
  world w{link};
  talus::handle<talus::sphere> ball;
  double dt = 2e-8;

  explicit pair_of_spheres(double tensile = 1e30, double shear = 1e30) {
    const auto m = w.material({.density = density, .stiffness = 1});
    w.interaction(m, m,
                  talus::parallel_bond::parameters{.youngs_modulus = modulus,
                                                   .poisson_ratio = ratio,
                                                   .range = radius,
                                                   .tensile_strength = tensile,
                                                   .shear_strength = shear,
                                                   .damping_ratio = 0.3});
    (void)w.add(talus::body{.shape = talus::sphere{radius}, .material = m, .fixed = true});
    ball = w.add(
        talus::body{.shape = talus::sphere{radius}, .position = {2 * radius, 0, 0}, .material = m});
    (void)talus::bond_within(w, 1e-6 * radius);
  }
  void step(const talus::vec3& force, const talus::vec3& torque) {
    w[ball].add_force(force), w[ball].add_torque(torque);
    w.step(dt);
  }
};

inline void single_bonds(report& out) {
  const double area = talus::pi * radius * radius, l = 2 * radius;
  const double polar = talus::pi / 2 * std::pow(radius, 4), shear = modulus / (2 * (1 + ratio));
  const auto add = [&](const std::string& what, const std::string& quantity,
                       const std::string& unit, double expected, double found,
                       const std::string& source) {
    out.push_back(
        {"bonds/" + what, quantity, unit, expected, found, 0.01 * std::abs(expected), source});
  };
  {
    pair_of_spheres p;
    const double force = 1e-4 * modulus * area;
    for (int k = 0; k < 20000; ++k) p.step({force, 0, 0}, {0, 0, 0});
    add("stretch", "elongation", "m", force * l / (modulus * area),
        p.w[p.ball].position()[0] - 2 * radius, "beam: F l / (E A)");
  }
  {
    pair_of_spheres p;
    const double torque = 1e-4 * shear * polar / l;
    double angle = 0;
    for (int k = 0; k < 20000; ++k) {
      p.step({0, 0, 0}, {torque, 0, 0});
      angle += p.dt * p.w[p.ball].angular_velocity()[0];
    }
    add("torsion", "angle", "rad", torque * l / (shear * polar), angle, "beam: T l / (G J)");
  }
  // The load grows slowly until the bond breaks.
  const auto breaks_at = [&](const talus::vec3& force, const talus::vec3& torque, bool tension) {
    pair_of_spheres p(tension ? 1e5 : 1e30, tension ? 1e30 : 1e5);
    const int steps = 100000;
    for (int k = 1; k <= steps; ++k) {
      const double load = 1.1 * k / steps;
      p.step(load * force, load * torque);
      if (k % 10 == 0 && talus::count_bonds(p.w).intact == 0) return load;
    }
    return 0.0;
  };
  const double strength = 1e5, second = polar / 2;
  add("break in tension", "load", "N", strength * area,
      strength * area * breaks_at({strength * area, 0, 0}, {0, 0, 0}, true),
      "Potyondy, Cundall 2004: sigma A");
  add("break by bending", "moment", "N m", strength * second / radius,
      strength * second / radius * breaks_at({0, 0, 0}, {0, strength * second / radius, 0}, true),
      "Potyondy, Cundall 2004: sigma I / r");
  add("break by torsion", "moment", "N m", strength * polar / radius,
      strength * polar / radius * breaks_at({0, 0, 0}, {strength * polar / radius, 0, 0}, false),
      "Potyondy, Cundall 2004: tau J / r");
}

/// A fibre of 20 elements, clamped at an end.
inline void fibre(report& out) {
  using namespace talus;
  const double L = 0.15, d = 2.83e-3, E = 1e9, rho = 420;
  const int elements = 20;
  const double l = L / elements, R = l / 2, section = pi * d * d / 4,
               second = pi * std::pow(d, 4) / 64;
  serial::link link;
  world w{link};
  const double bulk = rho * section * l / (4 * pi / 3 * R * R * R);
  const auto wood = w.material({.density = bulk, .stiffness = 1});
  const auto tip = w.material({.density = bulk / 2, .stiffness = 1});  // half an element
  const parallel_bond::parameters p{
      .youngs_modulus = E, .poisson_ratio = 0.3, .radius_multiplier = d / (2 * R), .range = R};
  w.interaction(wood, wood, p), w.interaction(wood, tip, p), w.interaction(tip, tip, p);
  handle<sphere> end;
  for (int k = 0; k <= elements; ++k)
    end = w.add(body{.shape = sphere{R},
                     .position = {k * l, 0, 0},
                     .material = k == elements ? tip : wood,
                     .fixed = k == 0});
  (void)bond_within(w, 1e-3 * R);
  const double P = 1e-4, expected = P * L * L * L / (3 * E * second), dt = 1.5e-6;
  const auto height = [&] { return w[end].position()[2]; };
  w.damping(std::exp(-340.0));
  for (int k = 0; k < 60000; ++k) {
    w[end].add_force({0, 0, P});
    w.step(dt);
  }
  out.push_back({"bonds/cantilever", "deflection", "m", expected, height(), 0.01 * expected,
                 "beam: P L^3 / (3 E I)"});
  w.damping(1);
  double before = height(), first = 0, period = 0;
  for (int k = 1, passes = 0; k < 80000 && passes < 3; ++k) {
    w.step(dt);
    const double now = height();
    if (before > 0 && now <= 0) {
      const double at = (k - now / (now - before)) * dt;
      if (++passes == 1) first = at;
      if (passes == 3) period = (at - first) / 2;
    }
    before = now;
  }
  const double frequency =
      std::pow(1.87510407, 2) / (2 * pi) * std::sqrt(E * second / (rho * section)) / (L * L);
  out.push_back({"bonds/fibre", "first eigenfrequency", "Hz", frequency, 1 / period,
                 0.01 * frequency,
                 "beam, clamped at an end: 1.8751^2 / (2 pi L^2) sqrt(E I / (rho A))"});
}

/// A face-centred cubic specimen, compressed along a cubic axis between its lowest layer, which is
/// fixed, and a load on its highest one. Periodic sides keep its width.
inline void uniaxial(report& out) {
  using namespace talus;
  using sides = periodic<grid<dynamic, dynamic>, along::x, along::y>;
  using specimen = scenario<bodies<sphere>, soft_contact<linear_spring_dashpot, parallel_bond>,
                            decomposition<sides>, transport<threads>, features<forces>>;
  const double l = 2 * radius, half = l / std::sqrt(2), multiplier = 0.5;
  constexpr int across = 8, layers = 8;  // sites of half a lattice constant
  const sides box{{.lower = {0, 0}, .upper = {across * half, across * half}}};
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    talus::world<specimen> w(link, box);
    const auto m = w.material({.density = density, .stiffness = 1});
    const parallel_bond::parameters p{.youngs_modulus = modulus,
                                      .poisson_ratio = ratio,
                                      .radius_multiplier = multiplier,
                                      .range = radius,
                                      .damping_ratio = 0.3};
    w.interaction(m, m, p);
    for (int k = 0; k < across * across * layers; ++k) {
      const int x = k % across, y = k / across % across, z = k / (across * across);
      if ((x + y + z) % 2 == 0)
        (void)w.add(body{.shape = sphere{radius},
                         .position = half * vec3(x + 0.5, y + 0.5, z),
                         .material = m,
                         .fixed = z == 0});
    }
    (void)bond_within(w, 1e-6 * radius);
    const parallel_bond::stiffnesses k =
        parallel_bond::stiffness(p, {.radius = multiplier * radius, .length = l});
    const double expected = std::sqrt(2) * (k.stretch + k.shear) / l, strain = 1e-5;
    const double load = strain * expected * l * l, top = (layers - 1) * half;  // on each sphere
    const double dt = critical_dt(w, 0) / 5;
    for (int step = 0; step < 4000; ++step) {
      w.for_each_local([&](auto& b) {
        if (b.position()[2] > top - 0.5 * half) b.add_force({0, 0, -load});
      });
      w.step(dt);
    }
    double sum = 0, count = 0;
    w.for_each_local([&](const auto& b) {
      if (b.position()[2] > top - 0.5 * half) sum += top - b.position()[2], count += 1;
    });
    out.push_back({"bonds/uniaxial compression", "modulus without change of width", "Pa", expected,
                   load / (l * l) / (sum / count / top), 0.01 * expected,
                   "lattice of springs: sqrt(2) (k_stretch + k_shear) / l"});
  });
}

}  // namespace bond_cases

inline void bonds(report& out, const effort&) {
  bond_cases::single_bonds(out);
  bond_cases::fibre(out);
  bond_cases::uniaxial(out);
}

}  // namespace validation
