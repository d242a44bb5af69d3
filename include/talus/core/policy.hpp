#pragma once
// A policy is a type that decides one part of a scenario.
#include <concepts>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>

#include "talus/core/misspelt.hpp"
#include "talus/core/not_there.hpp"

namespace talus {

/// The parts of a scenario that policies decide. `scenario<...>` takes at most one policy of each.
namespace roles {
struct bodies {};
struct contact_law {};
struct solver {};
struct broad_phase {};
struct integrator {};
struct decomposition {};
struct transport {};
struct precision {};
struct features {};
struct joints {};
}  // namespace roles

/// A policy names its role; `scenario<...>` takes policies in any order and recognises them by
/// their role.
template <class Type>
concept policy = requires {
  typename Type::talus_role;
};

namespace detail {

template <class Type, class Role>
concept plays = requires {
  requires std::same_as<typename Type::talus_role, Role>;
};

/// A type *inside* a policy, such as nonlinear_gauss_seidel in solver<...>, names the role of that
/// policy, so that the refusal of a bare part gives the right advice.
template <class Type, class Role>
concept part_for = requires {
  requires std::same_as<typename Type::talus_part_of, Role>;
};
/// Whether a type names this role as that of its policy. It is a plain constant, for which
/// compilers print less than for the concept part_for when it is false.
template <class Type, class Role>
inline constexpr bool is_part = part_for<Type, Role>;

/// A check whose static_assert refuses a type: its size is asked for, so that the compiler names
/// the refused type in "In instantiation of 'struct talus::detail::...<TYPE>'". What talus lacks is
/// refused where it is named. (An alias: a variable would add three lines to what clang prints.)
template <template <class> class Check, class Type>
using examined = std::conditional_t<is_missing<Type>, std::true_type, Check<Type>>;

/// The type in the compiler's description of a function: "... [with Type = X; ...]", clang: "[Type
/// = X]".
[[nodiscard, gnu::cold]] inline std::string type_in(std::string_view text) {
  text.remove_prefix(text.find("Type = ") + 7);
  std::string name(text.substr(0, text.find_first_of(";]")));
  for (std::size_t at; (at = name.find("talus::")) != std::string::npos;) name.erase(at, 7);
  return name;
}
/// The name of a type as the compiler spells it, without the namespace of talus.
template <class Type>
[[gnu::cold]] std::string spelled() {
  return type_in(__PRETTY_FUNCTION__);
}

/// The texts with `separator` in between; empty ones are left out.
[[nodiscard, gnu::cold]] inline std::string joined_text(std::initializer_list<std::string> texts,
                                                        const char* separator) {
  std::string all;
  for (const std::string& text : texts) {
    if (text.empty()) continue;
    if (!all.empty()) all += separator;
    all += text;
  }
  return all;
}

/// The name of a policy as the user spells it: its describe(), its constexpr name, or else its
/// type.
template <class Type>
[[gnu::cold]] std::string describe_policy() {
  if constexpr (requires { std::string(Type::describe()); })
    return Type::describe();
  else if constexpr (requires { std::string(Type::name); })
    return Type::name;
  else
    return spelled<Type>();
}

/// "bodies<sphere, box>" from "bodies", sphere and box.
template <class... Parts>
[[gnu::cold]] std::string describe_list(const char* name) {
  return joined_text({name, joined_text({describe_policy<Parts>()...}, ", ") + ">"}, "<");
}

}  // namespace detail
}  // namespace talus
