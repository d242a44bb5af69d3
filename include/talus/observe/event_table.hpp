#pragma once
// The events that features<events> has reported in the last step: as a range, as a table, counted.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/features/events.hpp"
#include "talus/observe/tables.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/unit_names.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The events of the last step that this rank reports, by the ids of their bodies. The other ranks
/// have other events. Empty before the first step.
template <class World>
[[nodiscard]] const std::vector<event>& events_of_step(const World& w) {
  return detail::own_state<events>(detail::view_of(w)).of_step_;
}

/// Collective: the events of the last step, each once, by the ids of their bodies, on all ranks:
/// the same in the same order on any ranks.
template <class Scenario>
[[nodiscard]] std::vector<event> all_events(world<Scenario>& w) {
  w.require_all_ranks("all_events");
  const std::vector<event>& mine = events_of_step(w);
  detail::byte_buffer bytes(mine.size() * sizeof(event));
  if (!mine.empty()) std::memcpy(bytes.data(), mine.data(), bytes.size());
  std::vector<event> all;
  for (const detail::byte_buffer& theirs : w.link().gather_all(bytes)) {
    if (theirs.empty()) continue;
    const std::size_t before = all.size();
    all.resize(before + theirs.size() / sizeof(event));
    std::memcpy(static_cast<void*>(all.data() + before), theirs.data(), theirs.size());
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Collective: the number of events of each kind in all steps so far, in the order of event_kind.
/// A restart continues to count.
template <class World>
[[nodiscard]] std::array<std::uint64_t, 5> total_events(World& w) {
  std::array<std::uint64_t, 5> n = detail::own_state<events>(detail::view_of(w)).totals_;
  w.link().reduce(reduction::sum, std::span<std::uint64_t>(n));
  return n;
}

namespace detail {
inline constexpr std::array<const char*, 5> event_names{"contact_begins", "contact_ends", "impact",
                                                        "enters", "leaves"};
}  // namespace detail

/// Collective: the events of the last step as columns, on rank 0: kind, id_a, id_b, region,
/// point_x, point_y, point_z, impulse, speed. An id that an event does not have is the largest
/// number.
template <class Scenario>
[[nodiscard, gnu::cold]] data_table event_table(world<Scenario>& w) {
  std::vector<event> all = all_events(w);
  if (w.rank() != 0) all.clear();
  std::vector<data_table::column> columns;
  const auto add = [&](const char* name, std::string_view dimension, auto&& value) {
    std::vector<std::remove_cvref_t<decltype(value(event{}))>> values;
    for (const event& e : all) values.push_back(value(e));
    columns.push_back(
        {name, dimension.empty() ? "" : detail::in_units(dimension, w.units()), std::move(values)});
  };
  add("kind", "", [](const event& e) {
    return std::string_view(detail::event_names[static_cast<std::size_t>(e.kind)]);
  });
  add("id_a", "", [](const event& e) { return value_of(e.a); });
  add("id_b", "", [](const event& e) { return value_of(e.b); });
  add("region", "", [](const event& e) { return static_cast<double>(e.region); });
  add("point_x", "L", [](const event& e) { return double(e.point[0]); });
  add("point_y", "L", [](const event& e) { return double(e.point[1]); });
  add("point_z", "L", [](const event& e) { return double(e.point[2]); });
  add("impulse", "M L/T", [](const event& e) { return double(e.impulse); });
  add("speed", "L/T", [](const event& e) { return double(e.speed); });
  return {std::move(columns), w.rank() == 0};
}

}  // namespace talus
