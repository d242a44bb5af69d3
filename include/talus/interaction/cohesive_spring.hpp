#pragma once
// Cohesive, elastic-plastic spheres: the law of Luding with linear branches.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/interaction/contact_kinematics.hpp"
#include "talus/interaction/normal_spring.hpp"

namespace talus {

/// Interaction law: a spring that yields when loaded and attracts when unloaded, with linear
/// branches (Walton, Braun 1986; Luding 2008, "Cohesive, frictional powders: contact models for
/// tension", Granular Matter 10, 235, section 2.3). The force follows k_1 d while the overlap d
/// grows. Unloading and reloading follow a steeper line from the largest overlap, which attracts
/// below some overlap, down to the limit -k_c d. Along the limit the largest overlap that the
/// contact remembers decreases. Friction has the bound mu (f_n + k_c d). It stands in the place of
/// linear_spring_dashpot, and takes no property of the materials but friction.
struct cohesive_spring final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "cohesive_spring";
  static constexpr bool central = true;

  /// The parameters of a pair of materials.
  struct parameters {
    real loading = 0;    ///< k_1, force per overlap
    real unloading = 0;  ///< k_2, that of the steepest line, at least k_1
    real cohesive = 0;   ///< k_c, of the limit of attraction, not negative
    /// Plastic overlap phi_f, over 2 R, at which the line of unloading is the steepest.
    real plasticity_depth = 0.05;
    real damping = 0;  ///< damping ratio of a dashpot beside k_1, in [0, 1]
    friend bool operator==(const parameters&, const parameters&) = default;
  };
  /// What a contact remembers from step to step.
  struct memory {
    real deepest = 0;  ///< the largest overlap that counts

    /// The columns of a checkpoint.
    template <class Memory, class F>
    static void each_column(Memory& m, F&& f) {
      f("deepest_overlap", m.deepest);
    }
  };

  /// Throws invalid_argument for parameters without meaning.
  static void require_parameters(const parameters& p) {
    const auto refuse = [](const char* field, real value, const char* wanted) {
      detail::fail<std::invalid_argument>("cohesive_spring has .{} = {}: give {}", field, value,
                                          wanted);
    };
    if (!(p.loading > 0) || !std::isfinite(p.loading))
      refuse("loading", p.loading, "a finite positive stiffness");
    if (!(p.unloading >= p.loading) || !std::isfinite(p.unloading))
      refuse("unloading", p.unloading, "a finite stiffness that is at least that of loading");
    if (!(p.cohesive >= 0) || !std::isfinite(p.cohesive))
      refuse("cohesive", p.cohesive, "a finite stiffness that is not negative");
    if (!(p.plasticity_depth > 0) || !std::isfinite(p.plasticity_depth))
      refuse("plasticity_depth", p.plasticity_depth, "a finite positive part of the diameter");
    if (!(p.damping >= 0 && p.damping <= 1))
      refuse("damping", p.damping, "a damping ratio in [0, 1]");
  }
  [[nodiscard]] static bearing bears(const contact_kinematics&, const parameters& p) {
    return {0, p.loading, real(2.0 / 7) * p.loading, p.damping};
  }
  [[nodiscard]] static bearing_force<bearing> force(const contact_kinematics& c,
                                                    const parameters& p, real dt, memory& m) {
    const real d = std::max(real(0), -c.gap);
    real deepest = yielded(c, p, m.deepest, d);
    if (dt > 0) m.deepest = deepest;
    const real push = std::max(line(c, p, deepest).at(d), -p.cohesive * d);
    const real dashpot = 2 * p.damping * std::sqrt(c.mass * p.loading) * c.normal.dot(c.velocity);
    bearing_force<bearing> f;
    static_cast<bearing&>(f) = bears(c, p);
    f.pressing = std::max(real(0), push - dashpot + p.cohesive * d);
    f.force = (push - dashpot) * c.normal;
    f.conserved = push * c.normal;
    return f;
  }
  /// The work that the contact gives back on the way to touch: negative where that takes work.
  [[nodiscard]] static stored_energy stored(const contact_kinematics& c, const parameters& p,
                                            const memory& m) {
    const real d = std::max(real(0), -c.gap);
    const straight unload = line(c, p, m.deepest);
    // Where the line meets the limit.
    const real meet = unload.stiffness * unload.zero / (unload.stiffness + p.cohesive);
    if (d <= meet) return {.normal = real(-0.5) * p.cohesive * d * d};
    const real here = d - unload.zero, there = meet - unload.zero;
    return {.normal = real(0.5) * (unload.stiffness * (here * here - there * there) -
                                   p.cohesive * meet * meet)};
  }
  [[nodiscard]] static real longest_step(const parameters& p, real mass, real stiffer = 1) {
    return detail::longest_step_of_spring(std::max(p.unloading, p.cohesive), mass, p.damping,
                                          stiffer);
  }
  /// Half a period of the steepest line.
  [[nodiscard]] static real duration(const parameters& p, const head_on_impact& hit) {
    return pi * detail::damped_duration(p.damping) *
           std::sqrt(hit.mass / std::max(p.unloading, p.cohesive));
  }
  /// The largest force that a contact bears in tension, after it had this overlap: (k - k_1) k_c /
  /// (k + k_c) of the overlap, with the stiffness k of its line of unloading.
  [[nodiscard]] static real pull_off_force(const parameters& p, real effective_radius,
                                           real overlap) {
    const contact_kinematics c{.radius = effective_radius};
    const straight unload = line(c, p, std::min(overlap, most(c, p)));
    return p.cohesive * unload.stiffness * unload.zero / (unload.stiffness + p.cohesive);
  }

 private:
  /// A line of unloading: stiffness times the overlap beyond `zero`.
  struct straight {
    real stiffness, zero;
    [[nodiscard]] real at(real d) const { return stiffness * (d - zero); }
  };
  /// The largest overlap that a contact remembers; infinite without plasticity.
  [[nodiscard]] static real most(const contact_kinematics& c, const parameters& p) {
    return p.unloading / (p.unloading - p.loading) * p.plasticity_depth * 2 * c.radius;
  }
  [[nodiscard]] static straight line(const contact_kinematics& c, const parameters& p,
                                     real deepest) {
    const real k = p.loading + (p.unloading - p.loading) * std::min(real(1), deepest / most(c, p));
    return {k, (1 - p.loading / k) * deepest};
  }
  /// The overlap that counts from now on: larger after loading, less along the limit of attraction,
  /// where (k + k_c) d = (k - k_1) d_max.
  [[nodiscard]] static real yielded(const contact_kinematics& c, const parameters& p, real deepest,
                                    real d) {
    const real limit = most(c, p);
    if (d >= deepest) return std::min(d, limit);
    if (line(c, p, deepest).at(d) >= -p.cohesive * d) return deepest;
    const real q = (p.unloading - p.loading) / limit;
    return std::min(deepest,
                    real(0.5) * (d + std::sqrt(d * (d + 4 * (p.loading + p.cohesive) / q))));
  }
};

}  // namespace talus
