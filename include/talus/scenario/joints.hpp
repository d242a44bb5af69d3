#pragma once
// joints<...>: the kinds of joints of a scenario. Nothing is compiled, stored or sent for others.
#include <string>
#include <type_traits>

#include "talus/concepts.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

namespace detail {

template <class Kind>
struct is_joint_kind : std::bool_constant<concepts::joint_kind<Kind>> {};

template <class Kind>
struct part_of_joints {
  static_assert(
      is_part<Kind, roles::joints>,
      "joints<...> takes kinds of joints, and this type is not one: remove it, or make it "
      "model talus::concepts::joint_kind");
  static_assert(!is_part<Kind, roles::joints> || is_joint_kind<Kind>::value,
                "joints<...> names a type that says it is a joint and lacks what a joint offers: "
                "name, rows, validate, anchors, fix and write");
};

}  // namespace detail

/// Policy: the kinds of joints that world.join(...) makes. Default: none.
template <class... Kinds>
struct joints final {
  static_assert((... && (sizeof(detail::examined<detail::part_of_joints, Kinds>) > 0)));
  static_assert(detail::all_different<type_list<Kinds...>>,
                "joints<...> names a kind of joint twice: keep one of the two");

  using talus_role = roles::joints;
  using list =
      detail::filter_types<detail::unique_types<type_list<Kinds...>>, detail::is_joint_kind>;

  [[gnu::cold]] static std::string describe() {
    return sizeof...(Kinds) == 0 ? std::string() : detail::describe_list<Kinds...>("joints");
  }
};

}  // namespace talus
