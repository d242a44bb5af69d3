#pragma once
// Calls the hooks of the features of a scenario at a stage of the step.
#include <array>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "talus/body/features.hpp"
#include "talus/body/stages.hpp"
#include "talus/concepts.hpp"
#include "talus/core/type_list.hpp"
#include "talus/state/state.hpp"

namespace talus {

/// The view that hooks of user-defined features take at a stage of the step: world/stage_view.hpp.
template <class Scenario, class Feature>
class stage_view;

namespace detail {

template <class Feature>
struct order_of_feature {
  using type = type_list<>;
};
template <class Feature>
requires requires { typename Feature::runs_after; }
struct order_of_feature<Feature> {
  using type = typename Feature::runs_after;
};

template <class... Features>
struct feature_order {
  static constexpr std::size_t size = sizeof...(Features);
  std::array<std::size_t, size> at{};
  bool possible = true;  ///< false if features wait for each other
};
/// Each feature after those of its `runs_after`, else in the order of the user.
template <class... Features>
[[nodiscard]] consteval feature_order<Features...> order_features() {
  constexpr std::size_t n = sizeof...(Features);
  std::array<std::array<bool, n>, n> waits{};  // [i][j]: i waits for j
  std::size_t i = 0;
  const auto note = [&]<class... After>(type_list<After...>) {
    const bool named[] = {false, contains_type<type_list<After...>, Features>...};
    for (std::size_t j = 0; j < n; ++j) waits[i][j] = named[j + 1];
    ++i;
  };
  (note(typename order_of_feature<Features>::type{}), ...);
  feature_order<Features...> order;
  std::array<bool, n> done{};
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t next = n;
    for (std::size_t f = 0; f < n && next == n; ++f) {
      bool ready = !done[f];
      for (std::size_t j = 0; j < n; ++j) ready = ready && (done[j] || !waits[f][j]);
      if (ready) next = f;
    }
    if (next == n) {
      order.possible = false;
      return order;
    }
    done[next] = true;
    order.at[k] = next;
  }
  return order;
}

/// The features of a list that act in a step, in their order.
template <class Features>
struct acting_features;
template <>
struct acting_features<type_list<>> {
  using type = type_list<>;
};
template <class Feature>
struct acting_features<type_list<Feature>> {
  using type = type_list<Feature>;
};
template <class... Features>
requires(sizeof...(Features) > 1) struct acting_features<type_list<Features...>> {
  static constexpr auto order = order_features<Features...>();
  static_assert(
      order.possible,
      "features<...> names features that run after each other, by their runs_after: leave "
      "one of these out");
  template <std::size_t... I>
  static auto in_order(std::index_sequence<I...>)
      -> type_list<std::tuple_element_t<order.at[I], std::tuple<Features...>>...>;
  using type = decltype(in_order(std::make_index_sequence<sizeof...(Features)>{}));
};
template <class... Features>
using features_with_hooks =
    join_lists<std::conditional_t<with_hooks<Features>, type_list<Features>, type_list<>>...>;

/// Whether the views that hooks of user-defined features take are defined, not only declared.
template <class Scenario, class Features>
inline constexpr bool views_are_defined = false;
template <class Scenario, class... Features>
inline constexpr bool views_are_defined<Scenario, type_list<Features...>> =
    (... &&
     (built_in<Features> || !with_hooks<Features> || complete<stage_view<Scenario, Features>>));

/// Whether a feature measures errors of the steps.
template <class Feature>
inline constexpr bool is_monitor =
    contains_type<type_list<energy_ledger, momentum_balance, penetration_monitor, residual_monitor>,
                  Feature>;

template <class Stage, class Feature, class Scenario, class State, class... More>
void run_hook(State& s, More&... more) {
  using hooks = typename Feature::hooks;
  static_assert(complete<hooks>, "the hooks of this feature are declared and not defined");
  if constexpr (built_in<Feature>) {
    if constexpr (requires { Stage::template call<hooks>(s, more...); }) {
      if constexpr (is_monitor<Feature> && contains_type<stages::all, Stage>) {
        const function_clock clock(s, s.functions.number(name_of_monitors));
        Stage::template call<hooks>(s, more...);
      } else {
        Stage::template call<hooks>(s, more...);
      }
    }
  } else if constexpr (contains_type<stages::all, Stage>) {
    using view = stage_view<Scenario, Feature>;
    if constexpr (complete<view>)
      if constexpr (requires(view & v) { Stage::template call<hooks>(v); }) {
        const function_clock clock(s, s.functions.number(Feature::name));
        view v(s);
        Stage::template call<hooks>(v);
      }
  }
}

template <class Stage, class Scenario, class State, class... More>
void run_all_hooks(State& s, More&... more) {
  [&]<class... Listed>(type_list<Listed...>) {
    [&]<class... Features>(type_list<Features...>) {
      (run_hook<Stage, Features, Scenario>(s, more...), ...);
    }(typename acting_features<features_with_hooks<Listed...>>::type{});
  }(typename Scenario::features{});
  (void)s, ((void)more, ...);
}

/// Calls the hooks of the features of the scenario at a stage, one after the other. The stages
/// within the exchange of bodies and within the search for contacts pass further arguments, to
/// built-in features only.
template <class Stage, class Scenario, class... More>
void run_hooks(world_state<Scenario>& s, More&... more) {
  run_all_hooks<Stage, Scenario>(s, more...);
}
/// Calls those hooks of the features of the scenario at a stage that only read the state.
template <class Stage, class Scenario, class... More>
void run_hooks(const world_state<Scenario>& s, More&... more) {
  run_all_hooks<Stage, Scenario>(s, more...);
}

/// Whether some built-in feature of a scenario acts at a stage.
template <class Stage, class Scenario, class... More>
inline constexpr bool has_hook = []<class... Features>(type_list<Features...>) {
  [[maybe_unused]] const auto acts = []<class Feature>() {
    if constexpr (built_in<Feature> && with_hooks<Feature>)
      return requires(world_state<Scenario> & s, More & ... more) {
        Stage::template call<typename Feature::hooks>(s, more...);
      };
    else
      return false;
  };
  return (false || ... || acts.template operator()<Features>());
}(typename Scenario::features{});
/// Whether some user-defined feature of a scenario acts at a stage.
template <class Stage, class Scenario>
inline constexpr bool has_own_hook = []<class... Features>(type_list<Features...>) {
  [[maybe_unused]] const auto acts = []<class Feature>() {
    if constexpr (!built_in<Feature> && with_hooks<Feature>)
      return requires(stage_view<Scenario, Feature> & v) {
        Stage::template call<typename Feature::hooks>(v);
      };
    else
      return false;
  };
  return (false || ... || acts.template operator()<Features>());
}(typename Scenario::features{});

}  // namespace detail
}  // namespace talus
