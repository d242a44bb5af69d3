#pragma once
// What the monitors of a scenario hold on one rank. Sums over ranks are made when somebody asks
// (observe/), never in a step.
#include <algorithm>
#include <cstdint>

#include "talus/body/features.hpp"
#include "talus/core/compensated_sum.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

namespace detail {

/// What a monitor records; nothing of other features.
template <class Feature>
struct record_slot {};
template <class Feature>
requires requires { typename Feature::record; }
struct record_slot<Feature> : Feature::record {};

/// One record for each monitor that is named; empty without any.
template <class Features>
struct monitor_records;
template <class... Features>
struct monitor_records<type_list<Features...>> : record_slot<Features>... {};

template <class Scenario, class Feature>
inline constexpr bool watches = contains_type<typename Scenario::features, Feature>;

}  // namespace detail
}  // namespace talus
