#pragma once
// decomposition<...> and transport<...>: the ownership of space, and the communication of ranks.
#include "talus/concepts.hpp"
#include "talus/core/policy.hpp"

namespace talus {

namespace detail {
/// Concepts as plain constants, for which compilers print less when they are false.
template <class Type>
inline constexpr bool is_decomposition = concepts::decomposition<Type>;
template <class Type>
inline constexpr bool is_movable_decomposition = concepts::movable_decomposition<Type>;
/// Whether it is periodic; see parallel/periodic.hpp.
template <class Type>
inline constexpr bool is_periodic = false;
template <class Type>
inline constexpr bool is_transport = concepts::transport<Type>;
}  // namespace detail

// Declared without their headers: headers that a program does not include cost nothing, and a
// missing include is refused with advice.
struct serial;
struct threads;
struct mpi;
struct as_launched;

namespace detail {
template <class Type>
inline constexpr bool is_named_transport =
    std::same_as<Type, serial> || std::same_as<Type, threads> || std::same_as<Type, mpi> ||
    std::same_as<Type, as_launched>;
}  // namespace detail

/// Policy: which rank owns which point of space. Default:
/// decomposition<grid<dynamic>>, which fits any number of ranks.
template <class Decomposition>
struct decomposition final {
  static_assert(detail::is_decomposition<Decomposition>,
                "decomposition<...> takes a decomposition, such as grid<2, 2> or by_hand, and this "
                "type is not one: see talus::concepts::decomposition");
  using talus_role = roles::decomposition;
  using type = Decomposition;
  static std::string describe() {
    std::string text = detail::describe_list<Decomposition>("decomposition");
    for (std::size_t at; (at = text.find("-1")) != std::string::npos;)
      text.replace(at, 2, "dynamic");
    return text;
  }
};

/// Policy: how ranks communicate: serial, threads, mpi or as_launched. Default:
/// transport<threads>.
template <class Transport>
struct transport final {
  static_assert(!std::same_as<Transport, mpi> || detail::complete<Transport>,
                "transport<mpi> needs MPI: write #include <talus/mpi.hpp>");
  static_assert(
      !std::same_as<Transport, as_launched> || detail::complete<Transport>,
      "transport<as_launched> needs MPI: write #include <talus/mpi.hpp>, or choose threads");
  static_assert(
      !detail::complete<Transport> || detail::is_transport<Transport>,
      "transport<...> takes serial, threads, mpi or as_launched, and this type is not one of "
      "them: see talus::concepts::transport");
  using talus_role = roles::transport;
  using type = Transport;
  static std::string describe() { return detail::describe_list<Transport>("transport"); }
};

}  // namespace talus
