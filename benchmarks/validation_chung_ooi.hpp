#pragma once
/// \file
/// Y. C. Chung, J. Y. Ooi, "Benchmark tests for verifying discrete element modelling codes at
/// particle impact level", Granular Matter 13 (2011) 643-656: the eight tests. Where an impact
/// slides from its beginning to its end, the expected values are the impulses of rigid bodies;
/// elsewhere those of `oblique_hertz`, an integration of the contact law of its own.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <talus/parallel/serial.hpp>
#include <talus/shape/plane.hpp>
#include <talus/world/world.hpp>
#include <vector>

#include "validation.hpp"

namespace validation {

namespace chung_ooi_cases {

using elastic =
    talus::scenario<talus::bodies<talus::sphere, talus::plane>,
                    talus::soft_contact<talus::hertz_mindlin, talus::coulomb_friction>,
                    talus::integrator<talus::velocity_verlet>, talus::transport<talus::serial>>;

/// Elastic properties of a substance.
struct substance {
  std::string name;
  double youngs_modulus, poisson_ratio, density;
};

/// Two bodies about to meet: a sphere at -radius on the x axis, and a sphere or a rigid plane.
struct impact {
  substance of;
  double radius = 0, speed = 0;  ///< of the first sphere; the second one rests or mirrors it
  double other_radius = 0;       ///< of the second sphere; 0: a plane
  double other_density = 0;      ///< of the second sphere
  bool mirrored = false;         ///< the second sphere moves against the first one
  bool rigid_plane = true;       ///< otherwise the plane is of the same substance
  double restitution = 1, friction = 0;
  double tangential_speed = 0;  ///< of the first sphere along y
  double spin = 0;              ///< of the first sphere about z
  double other_spin = 0;        ///< of the second sphere about z

  [[nodiscard]] double mass() const { return mass_of(of.density, radius); }
  [[nodiscard]] double other_mass() const { return mass_of(other_density, other_radius); }
  /// 1/m + 1/m of the partner.
  [[nodiscard]] double compliance() const {
    return 1 / mass() + (other_radius > 0 ? 1 / other_mass() : 0);
  }
  [[nodiscard]] double closing() const { return mirrored ? 2 * speed : speed; }
  [[nodiscard]] double effective_radius() const {
    return other_radius > 0 ? radius * other_radius / (radius + other_radius) : radius;
  }
  /// Velocity along y at the point of contact, of the first body relative to the second.
  [[nodiscard]] double slip() const {
    return tangential_speed + spin * radius + other_spin * other_radius;
  }
  /// E* of the pair.
  [[nodiscard]] double modulus() const {
    const double one = (1 - of.poisson_ratio * of.poisson_ratio) / of.youngs_modulus;
    return 1 / (other_radius > 0 || !rigid_plane ? 2 * one : one);
  }
  /// G* of the pair.
  [[nodiscard]] double shear() const {
    const double one = 2 * (2 - of.poisson_ratio) * (1 + of.poisson_ratio) / of.youngs_modulus;
    return 1 / (other_radius > 0 || !rigid_plane ? 2 * one : one);
  }
  /// Duration of the impact without damping: 2.943 d / v with the largest overlap d.
  [[nodiscard]] double duration() const { return 2.9432655 * deepest() / closing(); }
  [[nodiscard]] double deepest() const {
    return std::pow(15 * closing() * closing() /
                        (16 * compliance() * modulus() * std::sqrt(effective_radius())),
                    0.4);
  }
  static double mass_of(double density, double r) {
    return density * 4 / 3 * talus::pi * r * r * r;
  }
};

/// What an impact leaves behind.
struct outcome {
  double force = 0, overlap = 0, duration = 0;  ///< largest force and overlap
  double restitution = 0;                       ///< speed of separation over that of approach
  double tangential_speed = 0;                  ///< of the first sphere along y
  double spin = 0;                              ///< of the first sphere about z
};

/// The impact in a world of talus, in steps of duration / `steps`.
inline outcome simulate(const impact& i, double steps = 2000) {
  talus::serial::link link;
  talus::world<elastic> w(link);
  const auto stuff = w.material({.density = i.of.density,
                                 .restitution = i.restitution,
                                 .friction = i.friction,
                                 .youngs_modulus = i.of.youngs_modulus,
                                 .poisson_ratio = i.of.poisson_ratio});
  const auto other = w.material(
      {.density = i.other_radius > 0 ? i.other_density : i.of.density,
       .restitution = i.restitution,
       .friction = i.friction,
       .youngs_modulus = i.other_radius > 0 || !i.rigid_plane ? i.of.youngs_modulus : talus::rigid,
       .poisson_ratio = i.of.poisson_ratio});
  const auto a = w.add(talus::body{.shape = talus::sphere{i.radius},
                                   .position = {-i.radius, 0, 0},
                                   .material = stuff,
                                   .velocity = {i.speed, i.tangential_speed, 0},
                                   .angular_velocity = {0, 0, i.spin}});
  talus::handle<talus::sphere> b;
  const bool pair = i.other_radius > 0;
  if (pair)
    b = w.add(talus::body{.shape = talus::sphere{i.other_radius},
                          .position = {i.other_radius, 0, 0},
                          .material = other,
                          .velocity = {i.mirrored ? -i.speed : 0, 0, 0},
                          .angular_velocity = {0, 0, i.other_spin}});
  else
    w.global([&](auto& scope) {
      scope.add(talus::plane{.normal = {-1, 0, 0}, .offset = 0}, other);
    });
  const double dt = i.duration() / steps;
  outcome o;
  double before = i.closing(), overlap = 0, last = 0;
  do {
    w.step(dt);
    const double closing = w[a].velocity()[0] - (pair ? w[b].velocity()[0] : 0);
    last = overlap;
    overlap = w[a].position()[0] + i.radius - (pair ? w[b].position()[0] - i.other_radius : 0);
    o.force = std::max(o.force, (before - closing) / dt / i.compliance());
    o.overlap = std::max(o.overlap, overlap);
    before = closing;
    o.duration += overlap > 0 ? dt : dt * last / (last - overlap);  // the end lies within the step
  } while (overlap > 0 && o.duration < 100 * i.duration());
  o.restitution = -before / i.closing();
  o.tangential_speed = w[a].velocity()[1];
  o.spin = w[a].angular_velocity()[2];
  return o;
}

/// The impulses of rigid bodies that slide during the whole impact; true for a slip of at least
/// 3.5 mu (1 + e) v, for solid spheres.
inline bool slides(const impact& i) {
  return std::abs(i.slip()) >= 3.5 * i.friction * (1 + i.restitution) * i.closing();
}
inline outcome sliding_impulse(const impact& i) {
  const double impulse = i.friction * (1 + i.restitution) * i.closing() / i.compliance();
  const double sign = i.slip() < 0 ? -1 : 1;
  outcome o;
  o.restitution = i.restitution;
  o.tangential_speed = i.tangential_speed - sign * impulse / i.mass();
  o.spin = i.spin - sign * 2.5 * impulse / (i.mass() * i.radius);
  return o;
}

/// Elastic (e = 1) oblique impact: Hertz along the normal and the stiffness of Mindlin at no slip
/// across it, whose force is kept while the contact grows and shrinks with it (Thornton, Cummins,
/// Cleary 2013). Integrated in the coordinates of the contact alone by the classical method of
/// Runge and Kutta for the normal motion, and small steps for the path-dependent tangential force.
inline outcome oblique_hertz(const impact& i, int steps = 400000) {
  const double R = i.effective_radius(), dt = 1.2 * i.duration() / steps;
  const double bulk = 4.0 / 3 * i.modulus() * std::sqrt(R), shear = 8 * i.shear();
  const double across = 3.5 * i.compliance();
  const auto acceleration = [&](double d) {
    return d > 0 ? -bulk * d * std::sqrt(d) * i.compliance() : 0;
  };
  double d = 0, v = i.closing(), slip = i.slip(), tangential = 0, contact = 0, impulse = 0;
  for (int k = 0; k < steps && (d > 0 || k == 0); ++k) {
    const double k1 = acceleration(d), k2 = acceleration(d + dt / 2 * v);
    const double k3 = acceleration(d + dt / 2 * v + dt * dt / 4 * k1);
    const double k4 = acceleration(d + dt * v + dt * dt / 2 * k2);
    d += dt * v + dt * dt / 6 * (k1 + k2 + k3);
    v += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    const double grown = std::sqrt(R * std::max(d, 0.0));
    if (grown < contact) tangential *= grown / contact;
    contact = grown;
    tangential -= shear * contact * slip * dt;
    const double limit = i.friction * bulk * std::max(d, 0.0) * std::sqrt(std::max(d, 0.0));
    tangential = std::clamp(tangential, -limit, limit);
    slip += across * tangential * dt;
    impulse += tangential * dt;
  }
  outcome o;
  o.restitution = -v / i.closing();
  o.tangential_speed = i.tangential_speed + impulse / i.mass();
  o.spin = i.spin + 2.5 * impulse / (i.mass() * i.radius);
  return o;
}

inline std::string digits(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

/// Tests 1 and 2: published force, overlap and duration of an elastic impact along the normal.
inline void along_the_normal(report& out, const std::string& test, const impact& i, double force,
                             double overlap, double duration, const std::string& source) {
  const outcome o = simulate(i);
  const std::string name = "chung_ooi/" + test + "/" + i.of.name;
  out.push_back({name, "largest force", "N", force, o.force, 0.01 * force, source});
  out.push_back({name, "largest overlap", "m", overlap, o.overlap, 0.01 * overlap, source});
  out.push_back({name, "duration", "s", duration, o.duration, 0.01 * duration, source});
  out.push_back({name, "restitution", "1", 1, o.restitution, 0.005, source});
}

/// Tests 4 to 8: what an oblique impact does to tangential velocity and spin, in units of the speed
/// of approach. The tolerance of 1e-3 is that of the closed form; without a closed form it is
/// 0.005.
inline void obliquely(report& out, const std::string& name, const impact& i,
                      const std::string& source) {
  const bool closed = slides(i);
  if (!closed && i.restitution < 1) return;
  const outcome expected = closed ? sliding_impulse(i) : oblique_hertz(i);
  const outcome o = simulate(i, 5000);
  const double tolerance = closed ? 1e-3 : 5e-3, v = i.closing();
  const std::string from = source + (closed ? "; impulse of sliding friction"
                                            : "; integration of the law of Hertz and Mindlin");
  out.push_back({name, "tangential velocity over normal velocity", "1",
                 expected.tangential_speed / v, o.tangential_speed / v, tolerance, from});
  out.push_back({name, "velocity by rotation over normal velocity", "1",
                 expected.spin * i.radius / v, o.spin * i.radius / v, 2.5 * tolerance, from});
}

}  // namespace chung_ooi_cases

/// The eight tests. `quick` takes fewer angles and speeds of each.
inline void chung_ooi(report& out, const effort& how) {
  using namespace chung_ooi_cases;
  const auto every = [&](std::vector<double> all) {  // each second value if quick
    if (!how.quick) return all;
    std::vector<double> some;
    for (std::size_t k = 0; k < all.size(); k += 2) some.push_back(all[k]);
    return some;
  };
  const substance glass{"glass", 48e9, 0.20, 2800}, limestone{"limestone", 20e9, 0.25, 2500};
  const substance aluminium{"aluminium", 70e9, 0.30, 2699};
  const substance magnesium{"magnesium", 40e9, 0.35, 1800};
  const substance oxide{"aluminium oxide", 380e9, 0.23, 4000};
  const substance alloy{"aluminium alloy", 70e9, 0.33, 2700}, copper{"copper", 120e9, 0.35, 8900};
  const substance steel{"steel", 208e9, 0.30, 7850}, nylon{"nylon", 2.5e9, 0.40, 1000};
  const substance polyethylene{"polyethylene", 1e9, 0.40, 1400};
  const std::string paper = "Chung and Ooi 2011, test ";

  const auto pair_of = [](const substance& s) {
    return impact{.of = s,
                  .radius = 0.01,
                  .speed = 10,
                  .other_radius = 0.01,
                  .other_density = s.density,
                  .mirrored = true};
  };
  const std::string first = paper + "1: Hertz impact of two spheres";
  along_the_normal(out, "1", pair_of(glass), 10697, 274.1e-6, 40.34e-6, first);
  along_the_normal(out, "1", pair_of(limestone), 7108, 368.3e-6, 54.20e-6, first);

  const std::string second = paper + "2: Hertz impact on a rigid plane";
  along_the_normal(out, "2", {.of = aluminium, .radius = 0.1, .speed = 0.2}, 11370, 49.72e-6,
                   731.7e-6, second);
  along_the_normal(out, "2", {.of = magnesium, .radius = 0.1, .speed = 0.2}, 7233, 52.12e-6,
                   767.1e-6, second);

  for (const substance& s : {oxide, alloy})
    for (const double e : every({0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0})) {
      const outcome o = simulate({.of = s, .radius = 0.0025, .speed = 3.9, .restitution = e}, 4000);
      out.push_back({"chung_ooi/3/" + s.name + "/" + digits(e), "restitution", "1", e,
                     o.restitution, 0.005, paper + "3: impact with damping"});
    }

  const double degree = talus::pi / 180;
  for (const substance& s : {oxide, alloy})  // the angle from the normal; 3.9 m/s along the path
    for (const double angle : every({35, 40, 45, 50, 60, 70, 80, 85}))
      obliquely(out, "chung_ooi/4/" + s.name + "/" + digits(angle),
                {.of = s,
                 .radius = 0.0025,
                 .speed = 3.9 * std::cos(angle * degree),
                 .restitution = 0.98,
                 .friction = 0.092,
                 .tangential_speed = 3.9 * std::sin(angle * degree)},
                paper + "4: oblique impact, constant speed");

  for (const substance& s : {steel, polyethylene})
    for (const double speed : every({0.5, 1, 5, 8, 10, 15, 30, 70}))
      obliquely(out, "chung_ooi/5/" + s.name + "/" + digits(speed),
                {.of = s,
                 .radius = 1e-5,
                 .speed = 5,
                 .rigid_plane = false,
                 .friction = 0.3,
                 .tangential_speed = speed},
                paper + "5: oblique impact, constant normal velocity");

  // Tests 6 to 8: restitution 0.5, so that the impacts that slide have a closed form.
  for (const substance& s : {alloy, nylon})
    for (const double spin : every({5, 7, 9, 12, 22}))
      obliquely(
          out, "chung_ooi/6/" + s.name + "/" + digits(spin),
          {.of = s, .radius = 0.1, .speed = 0.2, .restitution = 0.5, .friction = 0.4, .spin = spin},
          paper + "6: rotating sphere on a rigid plane");
  for (const substance& s : {alloy, copper})
    for (const double spin : every({5, 7, 9, 12, 22}))
      obliquely(out, "chung_ooi/7/" + s.name + "/" + digits(spin),
                {.of = s,
                 .radius = 0.1,
                 .speed = 0.2,
                 .other_radius = 0.1,
                 .other_density = s.density,
                 .mirrored = true,
                 .restitution = 0.5,
                 .friction = 0.4,
                 .spin = spin,
                 .other_spin = spin},
                paper + "7: two rotating spheres");
  for (const substance& s : {alloy, nylon})
    for (const double spin : every({5, 7, 9, 12, 22}))
      obliquely(out, "chung_ooi/8/" + s.name + "/" + digits(spin),
                {.of = s,
                 .radius = 0.1,
                 .speed = 0.2,
                 .other_radius = 0.5,
                 .other_density = 1000 * s.density,
                 .restitution = 0.5,
                 .friction = 0.4,
                 .spin = spin},
                paper + "8: a rotating sphere on a large heavy one");
}

}  // namespace validation
