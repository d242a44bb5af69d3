#pragma once
/// \file
/// Liquid bridges between two spheres that are pulled apart: forces, rupture, the work of the
/// rupture, and the liquid that returns to the films.
#include <algorithm>
#include <cmath>
#include <string>
#include <talus/liquid.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

#include "validation.hpp"

namespace validation {

namespace bridge_cases {

/// Water between glass beads of 2 mm, in SI units; the beads are heavy, so that the bridge hardly
/// changes their speed.
inline constexpr double radius = 1e-3, density = 2.5e6, tension = 0.072, angle = 0.3,
                        volume = 4e-11, speed = 0.02, dt = 1e-6;
inline double mass() { return density * 4 * talus::pi / 3 * radius * radius * radius; }

template <class Bridge, class... Features>
using scene = talus::scenario<talus::bodies<talus::sphere>,
                              talus::soft_contact<talus::linear_spring_dashpot, Bridge>,
                              talus::transport<talus::serial>, talus::features<Features...>>;

struct pulled {
  double near = 0, half = 0;  ///< forces at a fiftieth and at half of the rupture distance
  double rupture = 0;         ///< last distance of the surfaces at which a force acts
  double work = 0;            ///< kinetic energy that the beads lose
};
/// Two beads start with a small overlap and part.
template <class Bridge>
pulled pull_apart(const typename Bridge::parameters& p) {
  talus::serial::link link;
  talus::world<scene<Bridge>> w(link);
  const auto m = w.material({.density = density, .restitution = 1, .stiffness = 1});
  w.interaction(m, m, p);
  const double start = 1e-12, expected = Bridge::rupture_distance(p, volume);
  talus::handle<talus::sphere> beads[2];
  for (const int side : {0, 1})
    beads[side] = w.add(talus::body{.shape = talus::sphere{radius},
                                    .position = {(2 * side - 1) * (radius - 0.5 * start), 0, 0},
                                    .material = m,
                                    .velocity = {(side - 0.5) * speed, 0, 0}});
  const auto distance = [&] {
    return w[beads[1]].position()[0] - w[beads[0]].position()[0] - 2 * radius;
  };
  pulled found;
  const double before = talus::measure_motion(w).kinetic_energy;
  while (distance() < 1.2 * expected) {
    const double gap = distance(), v = w[beads[1]].velocity()[0];
    w.step(dt);
    const double force = mass() * (v - w[beads[1]].velocity()[0]) / dt;
    if (gap <= 0.02 * expected) found.near = force;
    if (gap <= 0.5 * expected) found.half = force;
    if (force > 0) found.rupture = gap;
  }
  found.work = before - talus::measure_motion(w).kinetic_energy;
  return found;
}
/// The integral of the force from touch to the rupture, by Simpson's rule.
template <class Force>
double work_of(const Force& force, double rupture) {
  constexpr int parts = 1000;
  double sum = 0;
  for (int k = 0; k <= parts; ++k)
    sum += (k == 0 || k == parts ? 1 : k % 2 == 1 ? 4 : 2) * force(rupture * k / parts);
  return sum * rupture / parts / 3;
}
template <class Bridge, class Force>
void add_cases(report& out, const std::string& law, const Force& force, const std::string& source) {
  const pulled found =
      pull_apart<Bridge>({.tension = tension, .angle = angle, .volume = volume, .viscosity = 0});
  const double rupture = (1 + 0.5 * angle) * std::cbrt(volume);
  const auto add = [&](const char* what, const char* unit, double expected, double value,
                       const std::string& from) {
    out.push_back({"bridges/" + law, what, unit, expected, value, 0.01 * expected, from});
  };
  add("force at a fiftieth of the rupture distance", "N", force(0.02 * rupture), found.near,
      source);
  add("force at half of the rupture distance", "N", force(0.5 * rupture), found.half, source);
  add("rupture distance", "m", rupture, found.rupture, "Lian, Thornton, Adams 1993");
  add("work of the rupture", "J", work_of(force, rupture), found.work, source + ", integrated");
}

/// Two beads with unequal films collide, share a bridge and part.
inline void returned_liquid(report& out) {
  using films = talus::from_films<talus::willett_bridge>;
  talus::serial::link link;
  talus::world<scene<films, talus::surface_liquid>> w(link);
  const auto m = w.material({.density = density, .restitution = 1, .stiffness = 1e4});
  w.interaction(
      m, m,
      talus::willett_bridge::parameters{.tension = tension, .angle = angle, .volume = volume});
  for (const int side : {-1, 1})
    (void)w.add(talus::body{.shape = talus::sphere{radius},
                            .position = {side * 1.02 * radius, 0, 0},
                            .material = m,
                            .velocity = {-side * 5 * speed, 0, 0}});
  w.for_each_local(
      [](auto&& b) { b.template set<talus::liquid>(b.position()[0] > 0 ? 3e-11 : 1e-11); });
  const double before = talus::total_liquid(w).total();
  double most = 0;
  bool bridged = false;
  for (int k = 0; k < 20000; ++k) {
    w.step(dt);
    const auto now = talus::total_liquid(w);
    most = std::max(most, std::abs(now.total() - before));
    bridged = bridged || now.count > 0;
  }
  out.push_back({"bridges/films", "largest change of the sum of all liquid", "m3", 0,
                 bridged ? most : before, 1e-14 * before, "conservation"});
}

}  // namespace bridge_cases

inline void bridges(report& out, const effort&) {
  using namespace bridge_cases;
  const double touch = 2 * talus::pi * radius * tension * std::cos(angle);
  add_cases<talus::willett_bridge>(
      out, "Willett",
      [&](double s) {
        const double x = s * std::sqrt(radius / volume);
        return touch / (1 + 1.05 * x + 2.5 * x * x);
      },
      "Willett, Adams, Johnson, Seville 2000");
  add_cases<talus::rabinovich_bridge>(
      out, "Rabinovich",
      [&](double s) {
        if (s == 0) return touch;
        const double d = 0.5 * s * (std::sqrt(1 + 2 * volume / (talus::pi * radius * s * s)) - 1);
        return touch / (1 + 0.5 * s / d);
      },
      "Rabinovich, Esayanur, Moudgil 2005");
  returned_liquid(out);
}

}  // namespace validation
