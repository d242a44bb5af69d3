#pragma once
// Attractions beside a spring: DMT adhesion, cohesion in proportion to the area of contact, and van
// der Waals' force at a distance.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"

namespace talus {
namespace detail {

/// Throws invalid_argument for a parameter that is negative or not finite.
inline void require_parameter(const char* law, const char* field, real value,
                              const char* dimension) {
  if (!(value >= 0) || !std::isfinite(value))
    fail<std::invalid_argument>(
        "{} has .{} = {}: give a finite number that is not negative, of the dimension {}", law,
        field, value, dimension);
}

/// A force along the normal without memory whose change with the gap the springs beside it bound.
struct central_attraction {
  using talus_part_of = roles::contact_law;
  static constexpr bool central = true;
  using memory = no_memory;
};

}  // namespace detail

/// Interaction law: adhesion around the circle of contact (Derjaguin, Muller, Toporov 1975, J.
/// Colloid Interface Sci. 53, 314), for stiff and small bodies with weak adhesion: a constant force
/// 2 pi w R while the bodies touch, beside hertz_mindlin. That is also its pull-off force.
struct dmt_adhesion final : detail::central_attraction {
  static constexpr const char* name = "dmt_adhesion";

  /// The parameters of a pair of materials.
  struct parameters {
    /// Work of adhesion w per area, an energy over an area: twice the surface energy of equal
    /// materials.
    real work_of_adhesion = 0;
    friend bool operator==(const parameters&, const parameters&) = default;
  };

  /// Throws invalid_argument for a work of adhesion without meaning.
  static void require_parameters(const parameters& p) {
    detail::require_parameter(name, "work_of_adhesion", p.work_of_adhesion, "energy over area");
  }
  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real, memory&) {
    interaction_force f;
    f.force = f.conserved = -pull_off_force(p, c.radius) * c.normal;
    return f;
  }
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory&) {
    return {.normal = pull_off_force(p, c.radius) * std::min(real(0), c.gap)};
  }
  [[nodiscard]] static real longest_step(const parameters&, real) {
    return std::numeric_limits<real>::infinity();
  }
  [[nodiscard]] static real duration(const parameters&, const head_on_impact&) {
    return std::numeric_limits<real>::infinity();
  }
  /// 2 pi w R, for this effective radius.
  [[nodiscard]] static real pull_off_force(const parameters& p, real effective_radius) {
    return 2 * pi * p.work_of_adhesion * effective_radius;
  }
};

/// Interaction law: an attraction k A in proportion to the area A = 2 pi R d of the circle in which
/// two spheres overlap by d, beside a spring (the model SJKR of LIGGGHTS, there with all orders of
/// d). It makes a bulk cohesive with one number. There is no attraction at touch, and with
/// linear_spring_dashpot it only softens the spring: it needs k < K / (2 pi R).
struct linear_cohesion final : detail::central_attraction {
  static constexpr const char* name = "linear_cohesion";

  /// The parameters of a pair of materials.
  struct parameters {
    real energy_density = 0;  ///< k, energy over volume, a pressure
    friend bool operator==(const parameters&, const parameters&) = default;
  };

  /// Throws invalid_argument for an energy density without meaning.
  static void require_parameters(const parameters& p) {
    detail::require_parameter(name, "energy_density", p.energy_density, "energy over volume");
  }
  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real, memory&) {
    interaction_force f;
    f.force = f.conserved = (slope(c, p) * std::min(real(0), c.gap)) * c.normal;
    return f;
  }
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory&) {
    const real gap = std::min(real(0), c.gap);
    return {.normal = real(-0.5) * slope(c, p) * gap * gap};
  }
  [[nodiscard]] static real longest_step(const parameters&, real) {
    return std::numeric_limits<real>::infinity();
  }
  [[nodiscard]] static real duration(const parameters&, const head_on_impact&) {
    return std::numeric_limits<real>::infinity();
  }

 private:
  [[nodiscard]] static real slope(const contact_kinematics& c, const parameters& p) {
    return 2 * pi * c.radius * p.energy_density;
  }
};

/// Interaction law: van der Waals' attraction of two spheres at a distance S that is small against
/// their radii, A R / (6 S^2) (Hamaker 1937, Physica 4, 1058), up to a cutoff. Below the least
/// distance, and where bodies overlap, the force stays the same. Give a time step that resolves
/// the motion over the least distance.
struct van_der_waals final : detail::central_attraction {
  static constexpr const char* name = "van_der_waals";

  /// The parameters of a pair of materials.
  struct parameters {
    real hamaker = 0;  ///< A, an energy; of quartz in air 6.5e-20 J
    /// Distance of the surfaces below which the force no longer grows, a length: 1.65e-10 m for
    /// smooth surfaces, the height of the asperities for rough ones.
    real least_distance = 0;
    real cutoff = 0;  ///< distance of the surfaces beyond which there is no force, a length
    friend bool operator==(const parameters&, const parameters&) = default;
  };

  /// Throws invalid_argument for parameters without meaning.
  static void require_parameters(const parameters& p) {
    detail::require_parameter(name, "hamaker", p.hamaker, "energy");
    detail::require_parameter(name, "cutoff", p.cutoff, "length");
    if (!(p.least_distance > 0 && p.least_distance < p.cutoff))
      detail::fail<std::invalid_argument>(
          "van_der_waals has .least_distance = {} and .cutoff = {}: give a least distance that is "
          "positive and below the cutoff",
          p.least_distance, p.cutoff);
  }
  [[nodiscard]] static real range(const parameters& p, real) { return p.cutoff; }
  [[nodiscard]] static interaction_force force(const contact_kinematics& c, const parameters& p,
                                               real, memory&) {
    const real s = std::max(c.gap, p.least_distance);
    interaction_force f;
    f.force = f.conserved = (-p.hamaker * c.radius / (6 * s * s)) * c.normal;
    return f;
  }
  /// With a minus the work of the force from here to the cutoff.
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory&) {
    if (!(c.gap < p.cutoff)) return {};
    const real s = std::max(c.gap, p.least_distance), unit = p.hamaker * c.radius / 6;
    return {.normal = unit * (1 / p.cutoff - 1 / s + (c.gap < s ? (c.gap - s) / (s * s) : 0))};
  }
  [[nodiscard]] static real longest_step(const parameters&, real) {
    return std::numeric_limits<real>::infinity();
  }
  [[nodiscard]] static real duration(const parameters&, const head_on_impact&) {
    return std::numeric_limits<real>::infinity();
  }
  /// The force at touch, A R / (6 s^2) with the least distance s, for this effective radius.
  [[nodiscard]] static real pull_off_force(const parameters& p, real effective_radius) {
    return p.hamaker * effective_radius / (6 * p.least_distance * p.least_distance);
  }
};

}  // namespace talus
