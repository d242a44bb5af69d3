#pragma once
// Loops over tuples. (std::apply says the same, at ten times the cost to the compiler.)
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

namespace talus::detail {

/// Calls f(element) for each element of a tuple, in order.
template <class Tuple, class F>
constexpr void each_of(Tuple& tuple, F&& f) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (static_cast<void>(f(std::get<I>(tuple))), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<std::remove_const_t<Tuple>>>{});
}

}  // namespace talus::detail
