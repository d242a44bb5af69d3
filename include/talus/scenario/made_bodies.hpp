#pragma once
// The results of functions that make bodies for world.fill and insert_by_rate: a shape that the
// scenario does not name is refused where the function is passed.
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "talus/body/body.hpp"
#include "talus/core/random.hpp"
#include "talus/scenario/scenario.hpp"

namespace talus::detail {

/// The first shape of a result that the scenario does not name; void if it names all.
template <class Scenario, class Made>
struct missing_in {
  using type = void;
};
template <class Scenario, class Shape>
struct missing_in<Scenario, body<Shape>> {
  using type = std::conditional_t<takes_shape<Scenario, Shape>, void, Shape>;
};
template <class Scenario, class Made>
struct missing_in<Scenario, std::optional<Made>> : missing_in<Scenario, Made> {};
template <class Scenario, class First, class... Rest>
struct missing_in<Scenario, std::variant<First, Rest...>>
    : std::conditional_t<std::is_void_v<typename missing_in<Scenario, First>::type>,
                         missing_in<Scenario, std::variant<Rest...>>, missing_in<Scenario, First>> {
};

/// The first shape that the scenario does not name, in the result of a function of a site, or of a
/// site and random numbers; void if it names all, and for other functions.
template <class Scenario, class Site, class F>
struct missing_in_result {
  using type = void;
};
template <class Scenario, class Site, class F>
requires std::is_invocable_v<F&, const Site&, random_stream&>
struct missing_in_result<Scenario, Site, F>
    : missing_in<Scenario,
                 std::remove_cvref_t<std::invoke_result_t<F&, const Site&, random_stream&>>> {
};
template <class Scenario, class Site, class F>
requires(!std::is_invocable_v<F&, const Site&, random_stream&> &&
         std::is_invocable_v<F&, const Site&>) struct missing_in_result<Scenario, Site, F>
    : missing_in<Scenario, std::remove_cvref_t<std::invoke_result_t<F&, const Site&>>> {
};

/// The site that a set passes on; only sets of talus say it.
template <class Sites>
struct site_of {
  using type = void;
};
template <class Sites>
requires requires { typename Sites::site_type; }
struct site_of<Sites> {
  using type = typename Sites::site_type;
};

template <class Scenario, class Site, class F>
using missing_in_result_t =
    typename missing_in_result<Scenario, Site, std::remove_reference_t<F>>::type;
template <class Scenario, class Sites, class F>
using missing_in_fill = missing_in_result_t<Scenario, typename site_of<Sites>::type, F>;

/// The sentence that names a missing shape; empty for void.
template <class Shape>
[[nodiscard]] consteval auto missing_shape_or_none() {
  if constexpr (std::is_void_v<Shape>)
    return sentence("");
  else
    return words_on_missing_shape<Shape>();
}

}  // namespace talus::detail
