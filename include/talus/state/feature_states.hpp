#pragma once
// The states of the features of a scenario on each rank.
#include <type_traits>

#include "talus/body/features.hpp"
#include "talus/core/type_list.hpp"

namespace talus::detail {

/// A state that depends on the scenario: `template <class Scenario> struct state`.
template <class Feature, class Scenario>
concept with_state_of_scenario = requires {
  typename Feature::template state<Scenario>;
};
/// A state that does not: `struct state`.
template <class Feature>
concept with_state = requires {
  typename Feature::state;
};

/// The state of one feature. That of a feature of talus is a base, whose members the stages of a
/// step use by name; that of a user-defined feature is a member.
template <class Feature, class Scenario>
struct feature_slot {};
template <class Feature, class Scenario>
requires(built_in<Feature>&&
             with_state_of_scenario<Feature, Scenario>) struct feature_slot<Feature, Scenario>
    : Feature::template state<Scenario> {
};
template <class Feature, class Scenario>
requires(!built_in<Feature> &&
         with_state_of_scenario<Feature, Scenario>) struct feature_slot<Feature, Scenario> {
  typename Feature::template state<Scenario> state_of_feature;
};
template <class Feature, class Scenario>
requires(!built_in<Feature> && with_state<Feature>) struct feature_slot<Feature, Scenario> {
  typename Feature::state state_of_feature;
};

template <class Features, class Scenario>
struct slots_of_features;
template <class... Features, class Scenario>
struct slots_of_features<type_list<Features...>, Scenario> : feature_slot<Features, Scenario>... {};

/// Whether a user-defined feature has a state, and that state.
template <class Feature, class Scenario>
inline constexpr bool has_own_state =
    !built_in<Feature> && (with_state_of_scenario<Feature, Scenario> || with_state<Feature>);
template <class Feature, template <class> class State, class Scenario>
[[nodiscard]] auto& own_state(State<Scenario>& s) {
  return static_cast<feature_slot<Feature, Scenario>&>(s).state_of_feature;
}
template <class Feature, template <class> class State, class Scenario>
[[nodiscard]] const auto& own_state(const State<Scenario>& s) {
  return static_cast<const feature_slot<Feature, Scenario>&>(s).state_of_feature;
}

}  // namespace talus::detail
