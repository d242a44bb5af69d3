#pragma once
// Bonds: elastic beams between the centres of two bodies, which break.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/tangential_spring.hpp"

namespace talus {

/// How a bond has broken.
enum class bond_break : std::uint8_t {
  none,     ///< it holds, or there was no bond
  tension,  ///< the largest tensile stress exceeded the strength
  shear,    ///< the largest shear stress exceeded the strength
  range,    ///< the bodies separated to the end of the law's range
};

/// A part of soft_contact<...>: a round elastic beam between the centres of two bodies, with
/// stretch, shear, bending, torsion and damping. Stress at the rim and breakage after Potyondy and
/// Cundall 2004 (Int. J. Rock Mech. Min. Sci. 41, 1329, equations 16 and 17); the stiffness across
/// the normal is that of a Timoshenko beam, which is exact at the nodes for bodies of equal radius.
/// bond_within(world, distance) makes bonds. A broken bond does not form again by itself. The
/// forces of the other laws act in parallel, between bonded bodies too: an overlap is pushed apart
/// by both.
struct parallel_bond final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "parallel_bond";

  /// The parameters of a pair of materials. Bodies of a pair without Young's modulus are never
  /// bonded.
  struct parameters {
    real youngs_modulus = 0;     ///< of the bond, force over area; cement 1e10 Pa
    real poisson_ratio = 0;      ///< defines the shear modulus, for torsion and shear
    real radius_multiplier = 1;  ///< radius of the beam over that of the smaller body
    real range = 0;              ///< the gap of the surfaces up to which a bond can hold, length
    /// Stress that breaks a bond in tension, and in shear.
    real tensile_strength = std::numeric_limits<real>::infinity();
    real shear_strength = std::numeric_limits<real>::infinity();
    real weibull_modulus = 0;  ///< of the spread of both strengths; 0 for no spread
    std::uint64_t seed = 1;    ///< of the spread
    real damping_ratio = 0;    ///< of each mode of the pair; 1 is critical
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// What a pair remembers from step to step: the beam, and its deformation.
  struct memory {
    real radius = 0;     ///< of the beam; 0 without a bond
    real length = 0;     ///< between the centres, without force
    real gap = 0;        ///< of the surfaces, without force
    real weakening = 1;  ///< random factor of both strengths
    vec3 shear{0, 0, 0};
    vec3 bend{0, 0, 0};  ///< relative rotation across the normal
    real twist = 0;      ///< about it
    bond_break broken = bond_break::none;

    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("bond_radius", m.radius), f("bond_length", m.length), f("bond_gap", m.gap);
      f("bond_weakening", m.weakening), f("bond_shear", m.shear), f("bond_bend", m.bend);
      f("bond_twist", m.twist), f("bond_broken", m.broken);
    }
  };
  /// Spring constants of a beam: force over displacement, moment over angle.
  struct stiffnesses {
    real stretch = 0, shear = 0, bend = 0, twist = 0;
  };

  /// Throws invalid_argument for parameters without meaning.
  static void require_parameters(const parameters& p) {
    const auto refuse = [](const char* field, real value, const char* wanted) {
      detail::fail<std::invalid_argument>("parallel_bond has .{} = {}: give {}", field, value,
                                          wanted);
    };
    const auto require = [&](const char* field, real value) {
      if (!(value >= 0) || !std::isfinite(value))
        refuse(field, value, "a finite number that is not negative");
    };
    require("youngs_modulus", p.youngs_modulus), require("range", p.range);
    require("weibull_modulus", p.weibull_modulus), require("damping_ratio", p.damping_ratio);
    if (!(p.poisson_ratio > -1 && p.poisson_ratio <= 0.5))
      refuse("poisson_ratio", p.poisson_ratio, "a number above -1 and up to 0.5");
    if (!(p.radius_multiplier > 0) || !std::isfinite(p.radius_multiplier))
      refuse("radius_multiplier", p.radius_multiplier, "a finite positive number");
    if (!(p.tensile_strength > 0))
      refuse("tensile_strength", p.tensile_strength, "a positive stress, or infinity");
    if (!(p.shear_strength > 0))
      refuse("shear_strength", p.shear_strength, "a positive stress, or infinity");
  }
  [[nodiscard]] static real range(const parameters& p, real /*radius*/) { return p.range; }
  [[nodiscard]] static bool is_intact(const memory& m) { return m.radius != 0; }

  /// The stiffnesses of an intact beam.
  [[nodiscard]] static stiffnesses stiffness(const parameters& p, const memory& m) {
    const real square = m.radius * m.radius, area = pi * square, second = area * square / 4;
    const real l = m.length, bend = p.youngs_modulus * second / l;
    const real shear_modulus = p.youngs_modulus / (2 * (1 + p.poisson_ratio));
    // The shear coefficient of a circular section (Cowper 1966).
    const real k = 6 * (1 + p.poisson_ratio) / (7 + 6 * p.poisson_ratio);
    const real softer = 1 + 12 * bend / (k * shear_modulus * area * l);
    return {.stretch = p.youngs_modulus * area / l,
            .shear = 12 * bend / (l * l * softer),
            .bend = bend,
            .twist = shear_modulus * 2 * second / l};
  }

  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real dt, memory& m) {
    interaction_force f;
    if (m.radius == 0) return f;
    const real kept = across_energy(p, m);
    const vec3 n = c.normal;
    const vec3 slip = c.velocity - n.dot(c.velocity) * n, bending = c.spin - n.dot(c.spin) * n;
    m.shear = detail::carried_along(m.shear, n, dt * c.mean_spin) + dt * slip;
    m.bend = detail::carried_along(m.bend, n, dt * c.mean_spin) + dt * bending;
    m.twist += dt * n.dot(c.spin);
    const stiffnesses k = stiffness(p, m);
    const real pull = k.stretch * (c.gap - m.gap);
    if (dt > 0) {
      m.broken = exceeds(c, p, m, k, pull);
      if (m.broken != bond_break::none) {
        m = {.broken = m.broken};
        // The motion of this step did no work on the springs: what they held is lost.
        f.lost = kept;
        return f;
      }
    }
    f.conserved = -pull * n - k.shear * m.shear;
    f.conserved_moment = -k.bend * m.bend - k.twist * m.twist * n;
    f.force = f.conserved, f.moment = f.conserved_moment;
    if (p.damping_ratio > 0) {
      // The moment of inertia of spheres about their centres, from that about the contact point.
      const real inertia = c.rolling_inertia * (2 / real(7)), twice = 2 * p.damping_ratio;
      const auto dashpot = [&](real stiff, real mass) { return twice * std::sqrt(stiff * mass); };
      f.force -= dashpot(k.stretch, c.mass) * n.dot(c.velocity) * n;
      f.force -= dashpot(k.shear, c.mass) * slip;
      f.moment -= dashpot(k.bend, inertia) * bending;
      f.moment -= dashpot(k.twist, inertia) * n.dot(c.spin) * n;
    }
    return f;
  }
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory& m) {
    if (m.radius == 0) return {};
    const real stretch = c.gap - m.gap;
    return {.normal = stiffness(p, m).stretch * stretch * stretch / 2, .kept = across_energy(p, m)};
  }
  /// The largest tensile and shear stress of a beam, at its rim, in the middle of its length.
  struct stresses {
    real tension = 0, shear = 0;
  };
  [[nodiscard]] static stresses stress(const contact_kinematics& c, const parameters& p,
                                       const memory& m) {
    if (m.radius == 0) return {};
    const stiffnesses k = stiffness(p, m);
    return stress_of(m, k, k.stretch * (c.gap - m.gap));
  }
  /// Depends on all bonds of a body: see critical_dt(world).
  [[nodiscard]] static real longest_step(const parameters&, real) {
    return std::numeric_limits<real>::infinity();
  }
  [[nodiscard]] static real duration(const parameters&, const head_on_impact&) {
    return std::numeric_limits<real>::infinity();
  }

 private:
  [[nodiscard]] static real across_energy(const parameters& p, const memory& m) {
    const stiffnesses k = stiffness(p, m);
    return (k.shear * m.shear.squaredNorm() + k.bend * m.bend.squaredNorm() +
            k.twist * m.twist * m.twist) /
           2;
  }
  [[nodiscard]] static stresses stress_of(const memory& m, const stiffnesses& k, real pull) {
    const real square = m.radius * m.radius, area = pi * square, second = area * square / 4;
    return {
        pull / area + k.bend * m.bend.norm() * m.radius / second,
        k.shear * m.shear.norm() / area + k.twist * std::abs(m.twist) * m.radius / (2 * second)};
  }
  [[nodiscard]] static bond_break exceeds(const contact_kinematics& c, const parameters& p,
                                          const memory& m, const stiffnesses& k, real pull) {
    const stresses s = stress_of(m, k, pull);
    if (s.tension > m.weakening * p.tensile_strength) return bond_break::tension;
    if (s.shear > m.weakening * p.shear_strength) return bond_break::shear;
    // Just before the pair leaves the neighbour list, so that the loss is booked.
    if (c.gap > real(0.98) * p.range) return bond_break::range;
    return bond_break::none;
  }
};

}  // namespace talus
