#pragma once
// An interaction law of one's own: the capillary force of a liquid bridge.
#include <algorithm>
#include <cmath>
#include <limits>
#include <talus/talus.hpp>

/// A bridge forms where two wet surfaces touch, pulls them together while they part, and ruptures
/// at a distance. Force after Willett, Adams, Johnson, Seville 2000 (Langmuir 16, 9396), rupture
/// after Lian, Thornton, Adams 1993 (J. Colloid Interface Sci. 161, 138). The liquid itself is not
/// moved.
struct liquid_bridge {
  using talus_part_of = talus::roles::contact_law;  // it stands inside soft_contact<...>
  static constexpr const char* name = "liquid_bridge";
  static constexpr bool central = true;  // along the normal: no moment

  /// Of a pair of materials.
  struct parameters {
    double tension = 0;  ///< surface tension, force over length; water 0.072 N/m
    double angle = 0;    ///< of contact, radians, below pi/2
    double volume = 0;   ///< of liquid in a bridge
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// Of a contact, from step to step.
  struct memory {
    bool wet = false;  ///< whether there is a bridge
  };

  /// The gap up to which a bridge holds.
  static double range(const parameters& p, double /*radius*/) {
    return (1 + 0.5 * p.angle) * std::cbrt(p.volume);
  }
  /// On body a; the opposite acts on b.
  static talus::interaction_force force(const talus::contact_kinematics& c, const parameters& p,
                                        double /*dt*/, memory& m) {
    if (c.gap < 0 && p.volume > 0) m.wet = true;
    talus::interaction_force f;
    if (!m.wet) return f;
    const double x = std::max(0.0, c.gap) * thinness(c, p);
    f.force = -strength(c, p) / (1 + 1.05 * x + 2.5 * x * x) * c.normal;
    f.conserved = f.force;  // all of it comes from the stored energy
    return f;
  }
  /// The work that the force does from this gap to the rupture, with a minus.
  static talus::stored_energy stored(const talus::contact_kinematics& c, const parameters& p,
                                     const memory& m) {
    if (!m.wet) return {};
    const double end = integral(range(p, c.radius) * thinness(c, p));
    const double here = integral(std::max(0.0, c.gap) * thinness(c, p));
    const double overlap = std::min(0.0, c.gap);
    return {.normal = strength(c, p) * (overlap - (end - here) / thinness(c, p))};
  }
  /// The force hardly changes with the gap: it is the spring that bounds the time step.
  static double longest_step(const parameters&, double /*mass*/) {
    return std::numeric_limits<double>::infinity();
  }
  static double duration(const parameters&, const talus::head_on_impact&) {
    return std::numeric_limits<double>::infinity();
  }

  /// The pull of two bodies that touch, of this effective radius.
  static double pull_off_force(const parameters& p, double radius) {
    return 4 * talus::pi * radius * p.tension * std::cos(p.angle);
  }

 private:
  static double strength(const talus::contact_kinematics& c, const parameters& p) {
    return pull_off_force(p, c.radius);
  }
  /// The gap in the formula is scaled by sqrt(2 R / V), of the effective radius R.
  static double thinness(const talus::contact_kinematics& c, const parameters& p) {
    return std::sqrt(2 * c.radius / p.volume);
  }
  /// The integral of 1 / (1 + 1.05 x + 2.5 x^2).
  static double integral(double x) {
    const double root = std::sqrt(10 - 1.05 * 1.05);
    return 2 / root * std::atan((5 * x + 1.05) / root);
  }
};
