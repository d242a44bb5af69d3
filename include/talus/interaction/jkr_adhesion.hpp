#pragma once
// Elastic spheres that adhere: the law of Johnson, Kendall and Roberts.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/quick_functions.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/hertz_mindlin.hpp"
#include "talus/interaction/normal_spring.hpp"

namespace talus {

/// Interaction law: elastic spheres with adhesion inside the circle of contact (Johnson, Kendall,
/// Roberts 1971, Proc. R. Soc. A 324, 301), for soft bodies with strong adhesion. It stands in the
/// place of hertz_mindlin. Bodies attract each other from the first touch until the neck between
/// them tears, beyond touch: the pull-off force is 1.5 pi w R. Friction has the bound mu (f_n + 3
/// pi w R) (Thornton, Yin 1991, Powder Technol. 65, 153). A shape that is not a sphere counts as
/// one of its volume, an ellipsoid as one with its curvatures at the contact.
struct jkr_adhesion final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "jkr_adhesion";
  static constexpr bool central = true;

  /// For world.interaction: of a pair of materials, beside their moduli and restitution.
  struct given {
    /// Work of adhesion w per area, an energy over an area: twice the surface energy of equal
    /// materials.
    real work_of_adhesion = 0;
    friend bool operator==(const given&, const given&) = default;
  };
  /// The parameters of a pair of materials, computed from the elastic constants and from what the
  /// user gives.
  struct parameters {
    real modulus = 0;           ///< 4/3 E*
    real tangential = 0;        ///< 8 G*
    real damping = 0;           ///< damping ratio, not negative
    real work_of_adhesion = 0;  ///< energy over area
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// What a contact remembers from step to step.
  struct memory {
    bool touching = false;  ///< since the last touch the neck has not torn

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("touching", m.touching);
    }
  };

  /// Throws invalid_argument for a work of adhesion without meaning.
  static void require_parameters(const given& g) {
    if (!(g.work_of_adhesion >= 0) || !std::isfinite(g.work_of_adhesion))
      detail::fail<std::invalid_argument>(
          "jkr_adhesion has .work_of_adhesion = {}: give a finite number that is not negative, of "
          "the dimension energy over area",
          g.work_of_adhesion);
  }
  /// Throws invalid_argument for a material without Young's modulus.
  static void require_material(const material& m) {
    if (!(m.youngs_modulus > 0))
      detail::fail<std::invalid_argument>(
          "a material of a scenario with jkr_adhesion needs a positive Young's modulus, but has "
          "{}: set .youngs_modulus",
          m.youngs_modulus);
  }
  /// The field that makes a material rigid, or null if it is not rigid.
  [[nodiscard]] static const char* rigid_by(const material& m) {
    return hertz_mindlin::rigid_by(m);
  }
  [[nodiscard]] static parameters combine(const material& a, const material& b,
                                          const pair_material& both, const given& g) {
    const hertz_mindlin::parameters p = hertz_mindlin::combine(a, b, both);
    return {p.modulus, p.tangential, p.damping, g.work_of_adhesion};
  }
  /// The distance of the surfaces at which the neck tears, 3 a^2 / R with the radius a of its
  /// circle then.
  [[nodiscard]] static real range(const parameters& p, real radius) {
    const real a = neck(p, radius);
    return 3 * a * a / radius;
  }
  /// The stiffnesses of a contact that touches.
  [[nodiscard]] static growing_bearing bears(const contact_kinematics& c, const parameters& p) {
    const real a = circle(c, p).radius;
    return {{0, p.modulus * a, p.tangential * a, p.damping}, a, p.tangential};
  }
  [[nodiscard]] static bearing_force<growing_bearing> force(const contact_kinematics& c,
                                                            const parameters& p, real dt,
                                                            memory& m) {
    bearing_force<growing_bearing> f;
    bool touching = m.touching || c.gap < 0;
    if (dt > 0) m.touching = touching;
    if (!touching) return f;
    const contact_circle s = circle(c, p);
    static_cast<growing_bearing&>(f) = {
        {0, p.modulus * s.radius, p.tangential * s.radius, p.damping}, s.radius, p.tangential};
    constexpr real critical = 2.2360679774997896964;  // sqrt(5), as in hertz_mindlin
    real damping = critical * p.damping * std::sqrt(c.mass * f.stiffness);
    if (p.damping > 1 && c.step > 0)
      damping = std::min(damping, detail::most_damping * c.mass / c.step);
    const real push = s.force - damping * c.normal.dot(c.velocity);
    f.pressing = std::max(real{0}, push + 2 * pull_off_force(p, c.radius));
    f.force = push * c.normal;
    f.conserved = s.force * c.normal;
    return f;
  }
  /// With the minus of the work that tears the contact.
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory& m) {
    return {.normal = m.touching ? circle(c, p).energy : 0};
  }
  /// Rayleigh waves bound the step instead: see longest_step_of_body().
  [[nodiscard]] static real longest_step(const parameters&, real) {
    return std::numeric_limits<real>::infinity();
  }
  /// Returns the longest step that hertz_mindlin has for the body.
  [[nodiscard]] static real longest_step_of_body(const material& m, real radius) {
    return hertz_mindlin::longest_step_of_body(m, radius);
  }
  /// Returns the duration of an impact that hertz_mindlin has, or half a period about the
  /// equilibrium without load, if that is less.
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    const real impact = hertz_mindlin::duration({p.modulus, p.tangential, p.damping}, hit);
    if (!(p.work_of_adhesion > 0)) return impact;
    // The stiffness follows from s^3 = 6: dF/dd = 0.9 s^2 (pi w R / 6) R / a^2.
    const real a = neck(p, hit.radius);
    const real stiffness = real(0.9 * 3.3019272488946263) * pi / 6 * p.work_of_adhesion *
                           hit.radius * hit.radius / (a * a);
    return std::min(impact,
                    pi * detail::damped_duration(p.damping) * std::sqrt(hit.mass / stiffness));
  }

  /// The largest force that a contact bears in tension, 1.5 pi w R, for this effective radius.
  [[nodiscard]] static real pull_off_force(const parameters& p, real effective_radius) {
    return real(1.5) * pi * p.work_of_adhesion * effective_radius;
  }

 private:
  /// State of a contact that touches, at rest.
  struct contact_circle {
    real radius = 0;  ///< of the circle of contact
    real force = 0;   ///< positive where the bodies push each other apart
    real energy = 0;  ///< 0 where the neck tears
  };
  /// Radius of the circle of contact where the neck tears, (pi w R^2 / (8 E*))^(1/3).
  [[nodiscard]] static real neck(const parameters& p, real radius) {
    return detail::quick_cbrt(pi * p.work_of_adhesion * radius * radius / (6 * p.modulus));
  }
  /// With the radius s^2 a_0 of the circle over that where the neck tears, the overlap d is a_0^2 /
  /// R (s^4 - 4 s), the force pi w R / 6 (s^6 - 6 s^3).
  [[nodiscard]] static contact_circle circle(const contact_kinematics& c, const parameters& p) {
    const real a0 = neck(p, c.radius);
    if (!(a0 > 0)) {
      const real d = std::max(real(0), -c.gap), a = std::sqrt(c.radius * d);
      return {a, p.modulus * a * d, real(0.4) * p.modulus * a * d * d};
    }
    const real unit = a0 * a0 / c.radius;
    const real s = root(std::max(real(-3), -c.gap / unit));
    const real s2 = s * s, s3 = s * s2, s4 = s2 * s2,
               scale = pi / 6 * p.work_of_adhesion * c.radius;
    return {s2 * a0, scale * s3 * (s3 - 6),
            scale * unit * (s4 * (s3 * (real(0.4) * s3 - 4) + 6) - real(2.4))};
  }
  /// The root s >= 1 of s^4 - 4 s = x for x >= -3, by Newton from above.
  [[nodiscard]] static real root(real x) {
    real s = 1 + std::sqrt((x + 3) / 6);
    if (x > 0) s = std::min(s, std::sqrt(std::sqrt(x)) + real(1.6));
    for (int k = 0; k < 50; ++k) {
      const real slope = 4 * (s * s * s - 1);
      if (!(slope > 0)) break;
      const real step = (s * (s * s * s - 4) - x) / slope;
      if (!(step > real(1e-15) * s)) break;
      s -= step;
    }
    return std::max(real(1), s);
  }
};

}  // namespace talus
