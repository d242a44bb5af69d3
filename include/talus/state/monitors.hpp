#pragma once
// Records of the monitors of a scenario on one rank. observe/ sums them over ranks on request,
// never in a step.
#include <algorithm>
#include <cstdint>

#include "talus/body/features.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

namespace detail {

/// The record of a monitor; other features have none.
template <class Feature>
struct record_slot {};
template <class Feature>
requires requires { typename Feature::record; }
struct record_slot<Feature> : Feature::record {};

/// One record for each monitor of the scenario; empty without any.
template <class Features>
struct monitor_records;
template <class... Features>
struct monitor_records<type_list<Features...>> : record_slot<Features>... {};

template <class Scenario, class Feature>
inline constexpr bool monitored = contains_type<typename Scenario::features, Feature>;

}  // namespace detail
}  // namespace talus
