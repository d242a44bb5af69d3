#pragma once
// Liquid bridges between bodies: the capillary force and the viscous force of a pendular bridge,
// which forms where bodies touch and ruptures at a distance.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/portable_trigonometry.hpp"
#include "talus/core/quick_functions.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus {
namespace detail {

/// A law of liquid bridges. The radius r of its formulas is twice the effective one (Derjaguin
/// 1934): that of two equal spheres, 2 R_a R_b / (R_a + R_b) of unequal ones, twice the radius of a
/// sphere on a wall. S is the distance of the surfaces, not half of it. `Curve` has the capillary
/// force over 2 pi r gamma cos(theta): `pull(S, r, V)`, 1 at touch, and `work(S, r, V)`, an
/// antiderivative of it with respect to S.
template <class Curve>
struct bridge_law {
  using talus_part_of = roles::contact_law;
  static constexpr bool exerts_moment = false;

  /// The parameters of a pair of materials.
  struct parameters {
    real tension = 0;    ///< surface tension gamma, force over length; of water 0.072 N/m
    real angle = 0;      ///< of contact theta, radians, below pi/2
    real volume = 0;     ///< V of a bridge, length cubed; with from_films<...> the most it takes
    real viscosity = 0;  ///< dynamic, pressure times time; of water 1e-3 Pa s; 0: no viscous force
    /// Distance of the surfaces below which the viscous force no longer grows: the height of their
    /// asperities, a length; 0: a hundredth of the effective radius.
    real roughness = 0;
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// What a contact remembers from step to step.
  struct memory {
    real volume = 0;  ///< of its bridge; 0: there is none

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("bridge_volume", m.volume);
    }
  };

  /// Throws invalid_argument for parameters without meaning.
  static void require_parameters(const parameters& p) {
    const auto refuse = [](const char* field, real value, const char* wanted) {
      fail<std::invalid_argument>("a liquid bridge has .{} = {}: give {}", field, value, wanted);
    };
    const auto require = [&](const char* field, real value) {
      if (!(value >= 0) || !std::isfinite(value))
        refuse(field, value, "a finite number that is not negative");
    };
    require("tension", p.tension), require("volume", p.volume);
    require("viscosity", p.viscosity), require("roughness", p.roughness);
    if (!(p.angle >= 0 && p.angle < pi / 2))
      refuse("angle", p.angle, "a contact angle in radians from 0 to below pi/2");
  }
  /// The distance of the surfaces at which a bridge of the volume of `p` ruptures: (1 + theta/2)
  /// V^(1/3) (Lian, Thornton, Adams 1993).
  [[nodiscard]] static real range(const parameters& p, real /*radius*/) {
    return rupture_distance(p, p.volume);
  }
  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real /*dt*/, memory& m) {
    if (c.gap < 0) m.volume = p.volume;
    return m.volume > 0 ? force_of_bridge(c, p, m.volume) : interaction_force{};
  }
  /// With a minus the work of the capillary force from here to the rupture.
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory& m) {
    return {.normal = m.volume > 0 ? energy_of_bridge(c, p, m.volume) : 0};
  }
  /// The capillary force hardly changes with the gap: the springs beside it bound the step.
  [[nodiscard]] static real longest_step(const parameters&, real /*mass*/) {
    return std::numeric_limits<real>::infinity();
  }
  /// The time in which the viscous force stops two bodies that nearly touch, times pi: a fifth of
  /// the critical step that follows is a seventh of that time.
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    if (!(p.viscosity > 0)) return std::numeric_limits<real>::infinity();
    const contact_kinematics c{.gap = 0, .mass = hit.mass, .radius = hit.radius};
    return pi * hit.mass * closest(c, p) / (6 * pi * p.viscosity * hit.radius * hit.radius);
  }

  // The following functions take the volume of the bridge as an argument. Programs may use these
  // closed forms, too.

  /// The distance of the surfaces at which a bridge of this volume ruptures.
  [[nodiscard]] static real rupture_distance(const parameters& p, real volume) {
    return (1 + real(0.5) * p.angle) * quick_cbrt(volume);
  }
  /// Whether surfaces at this distance are too close for such a bridge to rupture.
  [[nodiscard]] static bool holds(const parameters& p, real volume, real distance) {
    const real stretch = 1 + real(0.5) * p.angle;
    return !(distance > 0) || distance * distance * distance < stretch * stretch * stretch * volume;
  }
  /// The capillary force at touch, 2 pi r gamma cos(theta), for this effective radius r / 2.
  [[nodiscard]] static real pull_off_force(const parameters& p, real effective_radius) {
    const real cosine = p.angle == 0 ? real(1) : real(portable::cos(p.angle));
    return 4 * pi * effective_radius * p.tension * cosine;
  }
  /// The capillary force at a distance S of the surfaces, positive where it attracts. It is that of
  /// touch where bodies overlap.
  [[nodiscard]] static real capillary_force(const parameters& p, real effective_radius, real volume,
                                            real distance) {
    return pull_off_force(p, effective_radius) *
           Curve::pull(std::max(real(0), distance), 2 * effective_radius, volume);
  }
  /// Force of a bridge of this volume that has not ruptured.
  [[nodiscard]] static interaction_force force_of_bridge(const contact_kinematics& c,
                                                         const parameters& p, real volume) {
    interaction_force f;
    f.conserved = -capillary_force(p, c.radius, volume, c.gap) * c.normal;
    f.force = f.conserved;
    if (p.viscosity > 0) f.force -= viscous_force(c, p, volume);
    return f;
  }
  [[nodiscard]] static real energy_of_bridge(const contact_kinematics& c, const parameters& p,
                                             real volume) {
    const real end = rupture_distance(p, volume);
    if (!(c.gap < end)) return 0;
    const real r = 2 * c.radius, here = std::max(real(0), c.gap);
    const real work = Curve::work(end, r, volume) - Curve::work(here, r, volume);
    return pull_off_force(p, c.radius) * (std::min(real(0), c.gap) - work);
  }

 private:
  [[nodiscard]] static real closest(const contact_kinematics& c, const parameters& p) {
    return std::max(c.gap, p.roughness > 0 ? p.roughness : real(0.01) * c.radius);
  }
  /// Along the normal 6 pi eta R^2 X^2 / S times the speed, of the effective radius R (Adams and
  /// Perchard 1985), with X = 1 - S / sqrt(S^2 + 2 V / (pi r)) for the finite volume (Pitois,
  /// Moucheront, Chateau 2000). Across it 6 pi eta R (8/15 ln(R/S) + 0.9588) times the speed
  /// (Goldman, Cox, Brenner 1967), 0 where that is negative.
  [[nodiscard]] static vec3 viscous_force(const contact_kinematics& c, const parameters& p,
                                          real volume) {
    const real gap = closest(c, p), r = 2 * c.radius;
    const real finite = 1 - gap / std::sqrt(gap * gap + 2 * volume / (pi * r));
    const real unit = 6 * pi * p.viscosity * c.radius;
    const real along = unit * c.radius * finite * finite / gap;
    const real ratio = c.radius / gap;
    const real across = unit * std::max(real(0), real(8.0 / 15) * quick_log(ratio) + real(0.9588));
    const real approach = c.normal.dot(c.velocity);
    return across * c.velocity + ((along - across) * approach) * c.normal;
  }
};

/// cos(theta) / (1 + 1.05 s + 2.5 s^2), s = S sqrt(r / V).
struct willett_curve {
  [[nodiscard]] static real pull(real gap, real r, real volume) {
    const real s = gap * std::sqrt(r / volume);
    return 1 / (1 + real(1.05) * s + real(2.5) * s * s);
  }
  [[nodiscard]] static real work(real gap, real r, real volume) {
    constexpr real root = 2.982867747654931;  // sqrt(4 * 2.5 - 1.05^2)
    const real scale = std::sqrt(r / volume);
    return 2 / (root * scale) * portable::atan2(5 * gap * scale + real(1.05), root);
  }
};
/// 1 / (1 + S / (2 d)), d = S/2 (sqrt(1 + 2 V / (pi r S^2)) - 1), without a division by S.
struct rabinovich_curve {
  [[nodiscard]] static real pull(real gap, real r, real volume) {
    return 1 - gap / std::sqrt(gap * gap + 2 * volume / (pi * r));
  }
  [[nodiscard]] static real work(real gap, real r, real volume) {
    return gap - std::sqrt(gap * gap + 2 * volume / (pi * r));
  }
};

}  // namespace detail

/// Interaction law: liquid bridges with the force that Willett, Adams, Johnson, Seville 2000
/// (Langmuir 16, 9396) fitted to solutions of the Laplace-Young equation, for V below 0.1 r^3: 2 pi
/// r gamma cos(theta) / (1 + 1.05 s + 2.5 s^2), s = S sqrt(r / V). A bridge of fixed volume forms
/// where bodies touch and ruptures at (1 + theta/2) V^(1/3).
struct willett_bridge final : detail::bridge_law<detail::willett_curve> {
  static constexpr const char* name = "willett_bridge";
};
/// Interaction law: liquid bridges with the force of Rabinovich, Esayanur, Moudgil 2005 (Langmuir
/// 21, 10992): 2 pi r gamma cos(theta) / (1 + S / (2 d)), d = S/2 (sqrt(1 + 2 V / (pi r S^2)) - 1),
/// which is the derivative of the energy of a cylinder of liquid. Their further term, of the
/// surface tension at the edge of the bridge, is part of that derivative already (Lambert, Chau,
/// Delchambre, Regnier 2008, Langmuir 24, 3157), and is left out. A bridge of fixed volume forms
/// where bodies touch and ruptures at (1 + theta/2) V^(1/3).
struct rabinovich_bridge final : detail::bridge_law<detail::rabinovich_curve> {
  static constexpr const char* name = "rabinovich_bridge";
};

}  // namespace talus
