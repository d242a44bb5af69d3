#pragma once
// Materials and the contact properties of each pair of them.
#include <cmath>
#include <cstdint>
#include <limits>

#include "talus/body/pair_table.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus {

/// Names a material of one world.
enum class material_id : std::uint16_t {};

/// As the stiffness or Young's modulus of a material: bodies of it are rigid, and a soft contact
/// has the stiffness of the other body alone. For fixed and global bodies, such as walls.
inline constexpr real rigid = std::numeric_limits<real>::infinity();

// If material{...} is given an unknown field, g++ prints the namespaces of a type, and clang the
// nearest field, so both print the list of fields. Written by ./dev docs --sheet.
inline namespace a_material_has_density_restitution_friction_dynamic_friction_stiffness_youngs_modulus_poisson_ratio_and_rolling_friction {

/// The material of bodies.
struct material {
  real density = 1;      ///< mass per volume; granite 2.8 in g/cm^3
  real restitution = 0;  ///< Newton's coefficient of restitution, in [0, 1]
  real friction = 0;     ///< Coulomb's coefficient of friction, static, and dynamic unless given
  /// Coefficient of dynamic friction; NaN means the same as `friction`.
  real dynamic_friction = std::numeric_limits<real>::quiet_NaN();
  // Only soft contacts use the following parameters; hard contacts ignore them.
  /// Force per overlap of two such bodies, or `rigid`; linear_spring_dashpot.
  real stiffness = 0;
  /// Force per area, or `rigid`; glass 7e10 Pa, often softened; hertz_mindlin.
  real youngs_modulus = 0;
  real poisson_ratio = 0.25;  ///< in [0, 0.5]; hertz_mindlin
  real rolling_friction = 0;  ///< lever arm of the rolling moment over the radius; 0.01 to 0.5

  /// Coefficient of dynamic friction, that of static friction unless given.
  [[nodiscard]] constexpr real sliding_friction() const {
    return dynamic_friction == dynamic_friction ? dynamic_friction : friction;
  }
};

}  // namespace
   // a_material_has_density_restitution_friction_dynamic_friction_stiffness_youngs_modulus_poisson_ratio_and_rolling_friction

/// Predefined materials of the pe tutorial, densities in g/cm^3.
namespace materials {
inline constexpr material iron{.density = 7.874, .restitution = 0.5, .friction = 0.1};
inline constexpr material copper{.density = 8.92, .restitution = 0.5, .friction = 0.1};
inline constexpr material granite{.density = 2.8, .restitution = 0.5, .friction = 0.1};
inline constexpr material oak{.density = 0.8, .restitution = 0.5, .friction = 0.1};
inline constexpr material fir{.density = 0.5, .restitution = 0.5, .friction = 0.1};
}  // namespace materials

/// Contact properties of a pair of materials.
struct pair_material {
  real restitution = 0;  ///< Newton's coefficient of restitution, in [0, 1]
  real friction = 0;     ///< static, and dynamic unless given
  /// At most `friction`; NaN means the same as that.
  real dynamic_friction = std::numeric_limits<real>::quiet_NaN();
  /// Force that touching bodies resist when they are pulled apart [M L/T^2]; normal_cohesion. Other
  /// laws do not use it.
  real cohesion = 0;

  /// Coefficient of dynamic friction, that of static friction unless given.
  [[nodiscard]] constexpr real sliding_friction() const {
    return dynamic_friction == dynamic_friction ? dynamic_friction : friction;
  }
};

namespace detail {
/// Properties of a pair without its own: arithmetic means.
[[nodiscard]] inline pair_material mean_of(const material& a, const material& b) {
  return {0.5 * (a.restitution + b.restitution), 0.5 * (a.friction + b.friction),
          0.5 * (a.sliding_friction() + b.sliding_friction())};
}
}  // namespace detail

/// The materials of a world. A pair has the arithmetic mean of its two materials (the rule of the
/// ancestor pe) unless properties of its own are set.
class material_table {
 public:
  /// Throws invalid_argument for a density that is not positive, a restitution outside [0, 1], a
  /// negative coefficient of friction, and beyond 65,535 materials.
  [[gnu::cold]] material_id add(const material& m);

  /// Sets the properties of contacts between `a` and `b`, in either order.
  void set_pair(material_id a, material_id b, const pair_material& p);

  /// A material. Throws invalid_argument for one of another world.
  [[nodiscard]] const material& operator[](material_id m) const {
    require_known(m);
    return materials_[index(m)];
  }
  /// Properties of contacts between `a` and `b`, in either order.
  [[nodiscard]] pair_material pair(material_id a, material_id b) const {
    const contribution &x = means_[index(a)], &y = means_[index(b)];
    if (x.has_pairs & y.has_pairs)
      if (const pair_material* own = own_pair(a, b)) return *own;
    return {0.5 * (x.restitution + y.restitution), 0.5 * (x.friction + y.friction),
            0.5 * (x.dynamic_friction + y.dynamic_friction)};
  }
  /// Whether any two materials may rebound.
  [[nodiscard]] bool rebounds() const { return rebounds_; }
  /// The pairs that have properties of their own.
  [[nodiscard]] const detail::pair_table<pair_material>& own_pairs() const { return pairs_; }
  /// Number of materials.
  [[nodiscard]] std::size_t size() const { return materials_.size(); }
  /// Grows with every change, so that data derived from the table can be kept.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

 private:
  /// The contribution of a material to the means of its pairs.
  struct contribution {
    real restitution, friction, dynamic_friction;
    std::uint64_t has_pairs;  ///< 1 if a pair of it has properties of its own, else 0
  };
  static std::size_t index(material_id m) { return static_cast<std::size_t>(m); }
  static std::uint32_t number(material_id m) { return static_cast<std::uint32_t>(m); }
  [[nodiscard, gnu::noinline]] const pair_material* own_pair(material_id a, material_id b) const {
    return pairs_.find(number(a), number(b));
  }

  void require_known(material_id m) const;
  static void check(real restitution, real friction, real dynamic);
  static void check_soft(const material& m);

  detail::plain_vector<material> materials_;
  detail::plain_vector<contribution> means_;  ///< of each material
  detail::pair_table<pair_material> pairs_;   ///< those that were set; no value is missing
  std::uint64_t revision_ = 0;
  bool rebounds_ = false;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/body/material_definitions.hpp"
#endif
