#pragma once
// soft_contact<...>: bodies overlap a little, or act on each other at a distance, by forces that
// depend on their positions and velocities (the discrete element method, after Cundall and Strack
// 1979). Its parts are interaction laws, whose forces add up, and resistances to sliding and
// rolling.
#include <algorithm>
#include <limits>
#include <string>
#include <type_traits>

#include "talus/body/material.hpp"
#include "talus/concepts.hpp"
#include "talus/contact/law.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"
#include "talus/interaction/composed_law.hpp"
#include "talus/interaction/hertz_mindlin.hpp"
#include "talus/interaction/linear_spring_dashpot.hpp"
#include "talus/interaction/parallel_bond.hpp"
#include "talus/interaction/rolling_resistance.hpp"
#include "talus/interaction/tangential_spring.hpp"

namespace talus {

namespace detail {

/// Parts that resist sliding and rolling, and need a law with a normal force.
template <class Part>
inline constexpr bool is_resistance =
    std::is_same_v<Part, coulomb_friction> || concepts::resistance<Part>;
template <class Part>
inline constexpr bool is_interaction_law = concepts::interaction_law<Part>;
template <class Part>
inline constexpr bool is_hard_part =
    std::is_same_v<Part, newton_restitution> || std::is_same_v<Part, normal_cohesion> ||
    std::is_same_v<Part, split_correction> || std::is_same_v<Part, no_correction>;

template <class Part>
struct part_of_soft_contact {
  static constexpr bool tagged = is_part<Part, roles::contact_law> && !is_hard_part<Part>;
  static_assert(
      tagged,
      "soft_contact<...> takes interaction laws, such as linear_spring_dashpot and "
      "hertz_mindlin, coulomb_friction and rolling_resistance, and this type is not one of "
      "them: remove it, or make it a law as docs/interaction_laws.md says");
  static_assert(!tagged || is_resistance<Part> || is_interaction_law<Part>,
                "soft_contact<...> names a type that says it is part of a contact law and lacks "
                "what an interaction law offers: name, parameters, memory, force, stored, "
                "longest_step and duration, as concepts::interaction_law lists them");
};

template <class Part>
struct is_law_part : std::bool_constant<is_interaction_law<Part>> {};
template <class Part>
struct is_resistance_part : std::bool_constant<is_resistance<Part>> {};
template <class Part>
struct is_bearing_part : std::bool_constant<concepts::bearing_law<Part>> {};

/// The laws of a list with a normal force for friction: none, one, or several that contradict each
/// other.
template <class List>
struct bearer {
  static constexpr std::size_t count = filter_types<List, is_bearing_part>::size;
  using type = find_type<List, is_bearing_part, void>;
};

/// The implementation of a resistance for this kind of bearing.
template <class Part, class Bearing>
struct resistance_on {
  using type = Part;
};
template <class Bearing>
struct resistance_on<coulomb_friction, Bearing> {
  using type = tangential_spring<Bearing>;
};

template <class Laws, class Resistances>
struct law_of_parts;
template <class... Laws, class... Resistances>
struct law_of_parts<type_list<Laws...>, type_list<Resistances...>> {
  using bearer_type = typename bearer<type_list<Laws...>>::type;
  using type = composed_law<bearer_type, type_list<Laws...>,
                            type_list<typename resistance_on<
                                Resistances, typename bearing_of_law<bearer_type>::type>::type...>>;
};

}  // namespace detail

/// Policy: the contact law of soft bodies, its parts in any order: interaction laws, whose forces
/// add up, and resistances to sliding and rolling. Restitution, friction and stiffness are those of
/// the materials. The time step must resolve the duration of a contact: see critical_dt(). A
/// user-defined law is a type that models concepts::interaction_law.
template <class... Parts>
struct soft_contact final {
  using talus_role = roles::contact_law;
  using list = type_list<Parts...>;

 private:
  using laws = detail::filter_types<list, detail::is_law_part>;
  using resistances = detail::filter_types<list, detail::is_resistance_part>;
  using bears = detail::bearer<laws>;
  static constexpr bool both_springs = detail::contains_type<list, hertz_mindlin> &&
                                       detail::contains_type<list, linear_spring_dashpot>;

 public:
  static constexpr bool soft = true;
  static constexpr bool friction = detail::contains_type<list, coulomb_friction>;
  static constexpr bool restitution = true;
  static constexpr bool correction = false;

  static_assert((... && (sizeof(detail::examined<detail::part_of_soft_contact, Parts>) > 0)));
  static_assert(detail::all_different<list>,
                "soft_contact<...> names a part twice: keep one of the two");
  static_assert(laws::size > 0,
                "soft_contact<...> names no spring: add linear_spring_dashpot or hertz_mindlin, or "
                "an interaction law of your own");
  static_assert(!both_springs,
                "soft_contact<...> names linear_spring_dashpot and hertz_mindlin, which contradict "
                "each other: keep one of them");
  static_assert(
      bears::count < 2 || both_springs,
      "soft_contact<...> names two laws that bear the bodies, and friction has one normal "
      "force: keep one of them");
  static_assert(laws::size == 0 || resistances::size == 0 || bears::count > 0,
                "soft_contact<...> names a resistance and no law that bears the bodies: add "
                "linear_spring_dashpot or hertz_mindlin, or let a law of your own offer bears()");
  static_assert(friction || !detail::contains_type<list, rolling_resistance>,
                "soft_contact<...> names rolling_resistance without coulomb_friction, but what "
                "slides freely never rolls: add coulomb_friction");

  /// All parts as one interaction law.
  using law = typename detail::law_of_parts<laws, resistances>::type;
  using memory = typename law::memory;  ///< of a contact from step to step
  /// Whether a contact has any memory.
  static constexpr bool remembers = !std::is_empty_v<memory>;

  static std::string describe() { return detail::describe_list<Parts...>("soft_contact"); }
};

}  // namespace talus
