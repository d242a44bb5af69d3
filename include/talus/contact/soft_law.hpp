#pragma once
// soft_contact<...>: bodies overlap a little, and springs and dashpots push them apart (the
// discrete element method, after Cundall and Strack 1979).
#include <type_traits>

#include "talus/contact/law.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

/// Force proportional to the overlap, and a dashpot that makes two spheres rebound with the
/// coefficient of restitution of their materials at any speed (Schwager, Poeschel 2007); 0 stands
/// for 0.005. The force never pulls.
struct linear_spring_dashpot final {
  using talus_part_of = roles::contact_law;
  using talus_part_of_soft_contact = void;
  static constexpr const char* name = "linear_spring_dashpot";
};
/// Elastic spheres (Hertz 1882): force with the power 3/2 of the overlap; across it the stiffness
/// of Mindlin (1949) at no slip; a dashpot that makes restitution independent of speed (Tsuji,
/// Tanaka, Ishida 1992). A shape that is not a sphere counts as one of its volume.
struct hertz_mindlin final {
  using talus_part_of = roles::contact_law;
  using talus_part_of_soft_contact = void;
  static constexpr const char* name = "hertz_mindlin";
};
/// A moment against rolling, from an elastic spring of rotation that yields at mu_r R |f_n|
/// (elastic-plastic spring-dashpot, model C of Ai, Chen, Rotter, Ooi 2011).
struct rolling_resistance final {
  using talus_part_of = roles::contact_law;
  using talus_part_of_soft_contact = void;
  static constexpr const char* name = "rolling_resistance";
};

namespace detail {

template <class Part>
struct part_of_soft_contact {
  static_assert(is_soft_part<Part> || std::is_same_v<Part, coulomb_friction>,
                "soft_contact<...> takes linear_spring_dashpot or hertz_mindlin, coulomb_friction "
                "and rolling_resistance, and this type is none of them: remove it");
};

/// What a soft contact keeps from step to step.
struct tangential_memory {
  vec3 spring{0, 0, 0};  ///< elongation across the normal, of a relative to b
  bool sliding = false;
};
struct hertz_memory {
  real contact_radius = 0;  ///< of the circle of touch
};
struct rolling_memory {
  vec3 turn{0, 0, 0};  ///< elastic angle of rolling, of a relative to b
};
struct no_tangential_memory {};
struct no_hertz_memory {};
struct no_rolling_memory {};

template <bool Friction, bool Hertz, bool Rolling>
struct soft_memory : std::conditional_t<Friction, tangential_memory, no_tangential_memory>,
                     std::conditional_t<Friction && Hertz, hertz_memory, no_hertz_memory>,
                     std::conditional_t<Rolling, rolling_memory, no_rolling_memory> {};

}  // namespace detail

/// Policy: the contact law of soft bodies, its parts in any order: one spring model, and what else
/// holds. Restitution, friction and stiffness are those of the materials. The time step must
/// resolve the duration of a contact: see critical_dt().
template <class... Parts>
struct soft_contact final {
  using talus_role = roles::contact_law;
  using list = type_list<Parts...>;

  static constexpr bool soft = true;
  static constexpr bool hertz = detail::contains_type<list, hertz_mindlin>;
  static constexpr bool friction = detail::contains_type<list, coulomb_friction>;
  static constexpr bool rolling = detail::contains_type<list, rolling_resistance>;
  static constexpr bool restitution = true;
  static constexpr bool correction = false;

  using memory = detail::soft_memory<friction, hertz, rolling>;
  /// Whether a contact keeps anything at all.
  static constexpr bool remembers = !std::is_empty_v<memory>;

  static_assert((... && detail::examined<detail::part_of_soft_contact<Parts>>));
  static_assert(detail::all_different<list>,
                "soft_contact<...> names a part twice: keep one of the two");
  static_assert(hertz || detail::contains_type<list, linear_spring_dashpot>,
                "soft_contact<...> names no spring: add linear_spring_dashpot or hertz_mindlin");
  static_assert(!hertz || !detail::contains_type<list, linear_spring_dashpot>,
                "soft_contact<...> names linear_spring_dashpot and hertz_mindlin, which contradict "
                "each other: keep one of them");
  static_assert(friction || !rolling,
                "soft_contact<...> names rolling_resistance without coulomb_friction, but what "
                "slides freely never rolls: add coulomb_friction");

  static std::string describe() { return detail::describe_list<Parts...>("soft_contact"); }
};

}  // namespace talus
