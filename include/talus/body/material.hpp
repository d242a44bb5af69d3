#pragma once
// Materials and the contact properties of each pair of them.
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

#include "talus/body/pair_table.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus {

/// Names a material of one world.
enum class material_id : std::uint16_t {};

/// A value for the stiffness or Young's modulus of a material: bodies of it are rigid, and a soft
/// contact has the stiffness of the other body alone. For fixed and global bodies, such as walls.
inline constexpr real rigid = std::numeric_limits<real>::infinity();

/// The name of a material, in pages and their legends.
class material_name {
 public:
  static constexpr std::size_t most = 31;  ///< bytes

  constexpr material_name() = default;
  /// Throws invalid_argument for a text that is too long.
  template <class Text>
  requires std::convertible_to<const Text&, std::string_view>
  constexpr material_name(const Text& text) {
    const std::string_view from = text;
    if (from.size() > most)
      throw std::invalid_argument("the name of a material has at most 31 bytes: shorten '" +
                                  std::string(from) + "'");
    for (std::size_t k = 0; k < from.size(); ++k) text_[k] = from[k];
    size_ = static_cast<unsigned char>(from.size());
  }
  [[nodiscard]] constexpr std::string_view text() const { return {text_, size_}; }

 private:
  char text_[most]{};
  unsigned char size_ = 0;
};

// If material{...} is given an unknown field, g++ prints the namespaces of a type, which list its
// fields, and clang the nearest field. Written by ./dev docs --sheet, as those of bodies and
// joints.
inline namespace a_material_has_density_restitution_friction_dynamic_friction_stiffness_youngs_modulus_poisson_ratio_rolling_friction_name_and_colour {

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
  // What pages and pictures show.
  material_name name{};  ///< in legends; up to 31 bytes
  /// red, green and blue, each in [0, 1]; NaN: one of its own among the materials
  vec3 colour = vec3::Constant(std::numeric_limits<real>::quiet_NaN());

  /// Coefficient of dynamic friction, that of static friction unless given.
  [[nodiscard]] constexpr real sliding_friction() const {
    return dynamic_friction == dynamic_friction ? dynamic_friction : friction;
  }
};

}  // namespace
   // a_material_has_density_restitution_friction_dynamic_friction_stiffness_youngs_modulus_poisson_ratio_rolling_friction_name_and_colour

/// Predefined materials of the pe tutorial, densities in g/cm^3.
namespace materials {
inline constexpr material iron{.density = 7.874,
                               .restitution = 0.5,
                               .friction = 0.1,
                               .name = "iron",
                               .colour = {0.5, 0.52, 0.56}};
inline constexpr material copper{.density = 8.92,
                                 .restitution = 0.5,
                                 .friction = 0.1,
                                 .name = "copper",
                                 .colour = {0.78, 0.46, 0.26}};
inline constexpr material granite{.density = 2.8,
                                  .restitution = 0.5,
                                  .friction = 0.1,
                                  .name = "granite",
                                  .colour = {0.62, 0.58, 0.56}};
inline constexpr material oak{.density = 0.8,
                              .restitution = 0.5,
                              .friction = 0.1,
                              .name = "oak",
                              .colour = {0.72, 0.55, 0.33}};
inline constexpr material fir{.density = 0.5,
                              .restitution = 0.5,
                              .friction = 0.1,
                              .name = "fir",
                              .colour = {0.87, 0.75, 0.52}};
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

/// How a coefficient of a pair of materials follows from those of the two.
enum class pair_rule : std::uint8_t {
  mean,     ///< the arithmetic mean, the rule of the ancestor pe
  least,    ///< the smaller one: what touches a material without friction slides freely
  product,  ///< the product: likewise
  table     ///< that of world.material_pair; a contact of a pair without an entry is an error
};

/// The rules for pairs of materials that have no properties of their own; what world.pair_rules
/// takes.
struct pair_rules {
  pair_rule restitution = pair_rule::mean;  ///< of Newton's coefficients of restitution
  pair_rule friction = pair_rule::mean;     ///< of Coulomb's coefficients, static and dynamic

  friend bool operator==(const pair_rules&, const pair_rules&) = default;
};

namespace detail {
/// "mean", "least", "product" or "table".
[[nodiscard]] const char* name_of(pair_rule rule);
}  // namespace detail

/// The materials of a world. A pair has what the rules make of its two materials, the arithmetic
/// mean unless others are set, or properties of its own.
class material_table {
 public:
  /// Throws invalid_argument for a density that is not positive, a restitution outside [0, 1], a
  /// negative coefficient of friction, and beyond 65,535 materials.
  [[gnu::cold]] material_id add(const material& m);

  /// Sets the properties of contacts between `a` and `b`, in either order.
  void set_pair(material_id a, material_id b, const pair_material& p);

  /// Sets how pairs without properties of their own follow from their materials. Throws
  /// invalid_argument for a value that is no rule.
  void set_rules(const pair_rules& rules);

  /// A material. Throws invalid_argument for one of another world.
  [[nodiscard]] const material& operator[](material_id m) const {
    require_known(m);
    return materials_[index(m)];
  }
  /// Properties of contacts between `a` and `b`, in either order. Throws runtime_error if a rule
  /// takes them from the table, which has no entry for them.
  [[nodiscard]] pair_material pair(material_id a, material_id b) const {
    const contribution &x = means_[index(a)], &y = means_[index(b)];
    if (x.looked_up & y.looked_up) return looked_up(a, b);
    return {0.5 * (x.restitution + y.restitution), 0.5 * (x.friction + y.friction),
            0.5 * (x.dynamic_friction + y.dynamic_friction)};
  }
  /// Whether any two materials may rebound.
  [[nodiscard]] bool rebounds() const { return rebounds_; }
  /// What the rules make of two materials, whether or not they have properties of their own.
  /// Throws as pair().
  [[nodiscard]] pair_material by_rule(material_id a, material_id b) const;
  /// The rules in use.
  [[nodiscard]] const pair_rules& rules() const { return rules_; }
  /// The properties that were set for a pair, in either order, or nullptr.
  [[nodiscard]] const pair_material* own_pair(material_id a, material_id b) const {
    return pairs_.find(number(a), number(b));
  }
  /// The rules in words, for summaries.
  [[nodiscard, gnu::cold]] std::string describe_rules() const;
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
    std::uint64_t looked_up;  ///< 1 if a pair of it may have other properties than means, else 0
  };
  static std::size_t index(material_id m) { return static_cast<std::size_t>(m); }
  static std::uint32_t number(material_id m) { return static_cast<std::uint32_t>(m); }
  /// The properties of a pair that may have others than means.
  [[nodiscard]] pair_material looked_up(material_id a, material_id b) const;

  void require_known(material_id m) const;
  static void check(real restitution, real friction, real dynamic);
  static void check_soft(const material& m);

  detail::plain_vector<material> materials_;
  detail::plain_vector<contribution> means_;  ///< of each material
  detail::pair_table<pair_material> pairs_;   ///< those that were set; no value is missing
  std::uint64_t revision_ = 0;
  bool rebounds_ = false;
  pair_rules rules_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/body/material_definitions.hpp"
#endif
