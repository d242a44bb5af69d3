#pragma once
/// \file
/// Laws of adhesion: pull-off forces, the overlap at rest, and elastic impacts with JKR adhesion.
#include <algorithm>
#include <cmath>
#include <string>
#include <talus/adhesion.hpp>
#include <talus/observe/critical_dt.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/shape/plane.hpp>
#include <talus/shape/sphere.hpp>
#include <talus/world/world.hpp>

#include "validation.hpp"

namespace validation {

namespace cohesion_cases {

template <class... Parts>
using scene =
    talus::scenario<talus::bodies<talus::sphere, talus::plane>, talus::soft_contact<Parts...>,
                    talus::integrator<talus::velocity_verlet>, talus::transport<talus::serial>>;

/// A grain of a powder: a soft sphere of 0.1 mm, in SI units.
inline constexpr double radius = 5e-5, density = 2500, modulus = 1e8, work = 0.02;
inline constexpr talus::material grain{
    .density = density, .restitution = 0.1, .stiffness = 50, .youngs_modulus = modulus};
inline double mass() { return density * 4 * talus::pi / 3 * radius * radius * radius; }
/// 1/E* = 2 (1 - nu^2) / E of two grains
inline double effective_modulus() { return modulus / (2 * (1 - 0.0625)); }

/// Force and overlap of a grain that hangs on a ceiling.
struct hanging {
  double pull_off = 0;  ///< the weight at which the grain falls
  double rest = 0;      ///< overlap without weight
};
/// A grain is pressed against the ceiling by the force `press`, and then its weight increases from
/// 0.9 to 1.1 of the expected pull-off force.
template <class... Parts, class Given>
hanging hang(const Given& given, double expected, double press, const effort& how) {
  talus::serial::link link;
  talus::world<scene<Parts...>> w(link);
  const auto m = w.material(grain);
  w.interaction(m, m, given);
  w.global([&](auto& scope) { scope.add(talus::plane{.normal = {0, 0, -1}}, m); });
  const auto ball = w.add(talus::body{
      .shape = talus::sphere{radius}, .position = {0, 0, -radius * (1 - 1e-6)}, .material = m});
  const int steps = how.quick ? 100000 : 500000;
  const double dt = 0.2 * talus::critical_dt(w);
  const auto load = [&](double from, double to) {  // positive downwards
    for (int k = 0; k < steps; ++k) {
      const double force = from + (to - from) * (k + 1) / steps;
      w.gravity({0, 0, -force / mass()});
      w.step(dt);
      if (-w[ball].position()[2] > 1.1 * radius) return force;
    }
    return to;
  };
  hanging found;
  load(0, -press), load(-press, 0), load(0, 0);
  found.rest = radius + w[ball].position()[2];
  load(0, 0.9 * expected);
  found.pull_off = load(0.9 * expected, 1.1 * expected);
  return found;
}

inline void pull_off_forces(report& out, const effort& how) {
  using namespace talus;
  const auto add = [&](const std::string& law, double expected, double found,
                       const std::string& source) {
    out.push_back(
        {"cohesion/pull-off/" + law, "force", "N", expected, found, 0.01 * expected, source});
  };
  const double e = effective_modulus();
  {
    const double expected = 1.5 * pi * work * radius;
    const hanging found =
        hang<jkr_adhesion>(jkr_adhesion::given{.work_of_adhesion = work}, expected, 0, how);
    add("JKR", expected, found.pull_off, "Johnson, Kendall, Roberts 1971: 1.5 pi w R");
    const double a = std::cbrt(6 * pi * work * radius * radius * 0.75 / e);
    const double rest = a * a / radius - std::sqrt(2 * pi * work * a / e);
    out.push_back({"cohesion/without load/JKR", "overlap", "m", rest, found.rest, 0.001 * rest,
                   "Johnson, Kendall, Roberts 1971: a^3 = 9 pi w R^2 / (2 E*)"});
  }
  {
    const double expected = 2 * pi * work * radius;
    const hanging found = hang<hertz_mindlin, dmt_adhesion>(
        dmt_adhesion::parameters{.work_of_adhesion = work}, expected, 0, how);
    add("DMT", expected, found.pull_off, "Derjaguin, Muller, Toporov 1975: 2 pi w R");
    const double rest = std::pow(0.75 * expected / (e * std::sqrt(radius)), 2.0 / 3);
    out.push_back({"cohesion/without load/DMT", "overlap", "m", rest, found.rest, 0.001 * rest,
                   "Hertz under the load 2 pi w R"});
  }
  {
    const double k = 3e6, stiff = 4.0 / 3 * e * std::sqrt(radius);
    const double slope = 2 * pi * radius * k,
                 expected = std::pow(slope, 3) / 3 / std::pow(1.5 * stiff, 2);
    const hanging found = hang<hertz_mindlin, linear_cohesion>(
        linear_cohesion::parameters{.energy_density = k}, expected, 0, how);
    add("SJKR with Hertz", expected, found.pull_off,
        "least force of 4/3 E* sqrt(R) d^1.5 - 2 pi R k d");
  }
  {
    const double hamaker = 6.5e-20, least = 1e-9;
    const double expected = hamaker * radius / (6 * least * least);
    const hanging found = hang<linear_spring_dashpot, van_der_waals>(
        van_der_waals::parameters{.hamaker = hamaker, .least_distance = least, .cutoff = 1e-6},
        expected, 0, how);
    add("van der Waals", expected, found.pull_off, "Hamaker 1937: A R / (6 S^2)");
  }
  {
    const double k1 = 20, k2 = 100, kc = 50, press = 1e-5, overlap = press / k1;
    const double most = k2 / (k2 - k1) * 0.05 * 2 * radius;
    const double k = k1 + (k2 - k1) * overlap / most;
    const double expected = kc * (k - k1) * overlap / (k + kc);
    const hanging found = hang<cohesive_spring>(
        cohesive_spring::parameters{.loading = k1, .unloading = k2, .cohesive = kc, .damping = 0.5},
        expected, press, how);
    add("Luding", expected, found.pull_off, "Luding 2008: k_c (k - k_1) d / (k + k_c)");
    out.push_back({"cohesion/without load/Luding", "overlap", "m", (1 - k1 / k) * overlap,
                   found.rest, 1e-3 * overlap, "Luding 2008: (1 - k_1 / k) d"});
  }
}

/// Head-on impact of two elastic grains with JKR adhesion: velocity after over that before; 0 if
/// they stick.
inline double restitution(double speed) {
  using namespace talus;
  serial::link link;
  world<scene<jkr_adhesion>> w(link);
  auto elastic = grain;
  elastic.restitution = 1;
  const auto m = w.material(elastic);
  w.interaction(m, m, jkr_adhesion::given{.work_of_adhesion = work});
  handle<sphere> balls[2];
  for (const int side : {0, 1})
    balls[side] = w.add(body{.shape = sphere{radius},
                             .position = {(2 * side - 1) * 1.001 * radius, 0, 0},
                             .material = m,
                             .velocity = {(1 - 2 * side) * 0.5 * speed, 0, 0}});
  const double dt = 0.05 * critical_dt(w);
  double closest = 2 * radius;
  for (int k = 0; k < 20000; ++k) {
    w.step(dt);
    const double distance = w[balls[1]].position()[0] - w[balls[0]].position()[0];
    closest = std::min(closest, distance);
    if (distance > 2.02 * radius && closest < 2 * radius)
      return (w[balls[1]].velocity()[0] - w[balls[0]].velocity()[0]) / speed;
  }
  return 0;
}

/// The loss of an elastic impact is 7.09 (w^5 R^4 / E*^2)^(1/3) at any speed.
inline void impacts(report& out) {
  const double R = radius / 2, m = mass() / 2, e = effective_modulus();
  const double loss = 7.0925 * std::cbrt(std::pow(work, 5) * std::pow(R, 4) / (e * e));
  const double sticking = std::sqrt(2 * loss / m);
  for (const double ratio : {0.9, 1.1, 1.5, 3.0}) {
    char name[64];
    std::snprintf(name, sizeof name, "cohesion/JKR impact/%.1f of the sticking velocity", ratio);
    out.push_back({name, "restitution", "1", ratio > 1 ? std::sqrt(1 - 1 / (ratio * ratio)) : 0,
                   restitution(ratio * sticking), 0.005,
                   "Thornton, Ning 1998: 7.09 (w^5 R^4 / E*^2)^(1/3) is lost"});
  }
}

}  // namespace cohesion_cases

inline void cohesion(report& out, const effort& how) {
  cohesion_cases::pull_off_forces(out, how);
  cohesion_cases::impacts(out);
}

}  // namespace validation
