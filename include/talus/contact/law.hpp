#pragma once
// hard_contact<...>: bodies do not overlap, and the parts add friction, restitution and correction.
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Tangential impulse in the cone |p_t| <= mu p_n, against the sliding (Coulomb). Without it:
/// frictionless, and nothing tangential is stored or computed.
struct coulomb_friction final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "coulomb_friction";

  /// Rows of the Delassus block of a contact: the normal and two tangents.
  static constexpr int rows = 3;
  /// Projects impulses (normal, tangential) of one or several contacts into the cones with the
  /// friction coefficients mu: the normal part is raised to 0, then the tangential one is
  /// shortened. Without a branch: whether a contact slides is hard to predict.
  template <class Pack, class Tangential>
  [[gnu::always_inline]] static void project(Pack& n, Tangential& t, const Pack& mu) {
    using namespace detail;
    n = larger(n, every_lane<Pack>(0));
    const Pack limit = mu * n, length = square_root(dot(t, t));
    t = (limit / larger(larger(length, limit), every_lane<Pack>(smallest<lane_of<Pack>>))) * t;
  }

 private:
  /// Shorter impulses count as zero.
  template <class Real>
  static constexpr Real smallest = std::is_same_v<Real, double> ? Real(1e-150) : Real(1e-19);
};
/// Normal velocity after an impact = -e times the one before (Newton). Without it: plastic, e = 0.
struct newton_restitution final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "newton_restitution";
};
/// Touching surfaces stick: the normal impulse of a pair of bodies may pull with up to F_c dt, with
/// F_c = pair_material::cohesion, and |p_t| <= mu (p_n + F_c dt). This is the cone of Coulomb
/// shifted along the normal: Coulomb's law with cohesion (Radjai and Dubois, "Discrete-element
/// modeling of granular materials", 2011). A pair shares F_c equally among its touching points.
/// Surfaces touch if their gap is within the slack of detection, contact_slack times the (smaller)
/// bounding radius, or would be closed by gravity in a step; beyond that they part. Observers of
/// contact forces show p + F_c dt. Zero cohesion is the law without this part.
struct normal_cohesion final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "normal_cohesion";
};
/// The position correction: overlap from round-off and truncated iterations is removed from the
/// positions alone; the correction never enters the velocities, so it adds no kinetic energy. On
/// unless turned off.
struct split_correction final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "split_correction";
};
/// No position correction: a contact only keeps overlaps from growing.
struct no_correction final {
  using talus_part_of = roles::contact_law;
  static constexpr const char* name = "no_correction";
};

namespace detail {

/// What a hard law without friction has in place of coulomb_friction: its cone is the normal.
struct frictionless final {
  static constexpr int rows = 1;
  template <class Pack>
  [[gnu::always_inline]] static void project(Pack& n) {
    n = larger(n, every_lane<Pack>(0));
  }
};
template <bool Friction>
using cone_of = std::conditional_t<Friction, coulomb_friction, frictionless>;

#pragma GCC diagnostic pop

/// Whether touching surfaces attract each other; see normal_cohesion.
template <class Law>
inline constexpr bool is_cohesive = requires {
  requires Law::cohesive;
};

/// A hard contact law whose contacts also carry a velocity bias; see constraint/contact_bias.hpp.
template <class Law>
struct biased_law {
  using memory = typename Law::memory;
  using cone = typename Law::cone;
  static constexpr bool soft = false, biased = true;
  static constexpr bool friction = Law::friction;
  static constexpr bool restitution = Law::restitution;
  static constexpr bool correction = Law::correction;
  static constexpr bool cohesive = is_cohesive<Law>;
};
template <class Law>
inline constexpr bool has_bias = requires {
  requires Law::biased;
};

/// The properties on which the solution of a contact depends: contacts of all laws that agree in
/// them have one type.
template <bool Friction, bool Biased, bool Restitution>
struct rows_of_contact {
  using cone = cone_of<Friction>;
  static constexpr bool friction = Friction, biased = Biased, restitution = Restitution;
};
template <class Law>
using contact_rows = rows_of_contact<Law::friction, has_bias<Law>, Law::restitution>;

/// Parts for soft_contact<...> only: they have parameters of their own.
template <class Part>
inline constexpr bool is_law_or_resistance = requires {
  typename Part::parameters;
};

template <class Part>
struct part_of_hard_contact {
  static_assert(is_part<Part, roles::contact_law> && !is_law_or_resistance<Part>,
                "hard_contact<...> takes coulomb_friction, newton_restitution, normal_cohesion, "
                "split_correction and no_correction, and this type is not one of them: remove it");
};

}  // namespace detail

/// Policy: the contact law, its parts in any order. Default: hard_contact<coulomb_friction,
/// newton_restitution, split_correction>; hard_contact<> is frictionless and plastic.
template <class... Parts>
struct hard_contact final {
  using talus_role = roles::contact_law;
  using list = type_list<Parts...>;
  using memory = vec3;  ///< of a contact from step to step: its impulse

  static constexpr bool soft = false;
  static constexpr bool friction = detail::contains_type<list, coulomb_friction>;
  static constexpr bool restitution = detail::contains_type<list, newton_restitution>;
  static constexpr bool cohesive = detail::contains_type<list, normal_cohesion>;
  using cone = detail::cone_of<friction>;  ///< its part that projects impulses
  /// Whether overlaps are corrected; the default if no correction is named.
  static constexpr bool correction = !detail::contains_type<list, no_correction>;

  static_assert((... && (sizeof(detail::examined<detail::part_of_hard_contact, Parts>) > 0)));
  static_assert(detail::all_different<list>,
                "hard_contact<...> names a part twice: keep one of the two");
  static_assert(correction || !detail::contains_type<list, split_correction>,
                "hard_contact<...> names split_correction and no_correction, which contradict each "
                "other: keep one of them");

  static std::string describe() { return detail::describe_list<Parts...>("hard_contact"); }
};

}  // namespace talus
