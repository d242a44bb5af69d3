#pragma once
// How ranks agree on the colours of contacts. For solvers that sweep colour by colour.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/state/periodic_ghosts.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The id of a body in the arrays of the solver; no_id if it is not one of the bodies of this rank
/// and their copies.
template <class Scenario>
[[nodiscard]] system_id id_of_number(const world_state<Scenario>& s, std::size_t number) {
  system_id id = no_id;
  s.each_finite_shape([&](const auto& b) {
    if (number >= b.first && number - b.first < b.movable.size())
      id = b.movable.id[number - b.first];
  });
  return id;
}

/// In a small periodic box this rank may have several images of one body of another rank: all
/// shared contacts use the first one.
template <class Scenario>
void use_single_images(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::periodic) {
    if (s.travelling.empty() || sees_single_images(s)) return;
    plain_vector<std::int32_t> first;
    std::unordered_map<std::uint64_t, std::int32_t> of_id;
    for (const auto& other : s.travelling)
      for (const std::uint32_t i : other.received) {
        if (first.size() <= i) first.resize(i + 1, -1);
        const auto number = static_cast<std::int32_t>(i);
        std::int32_t& one = of_id.emplace(value_of(id_of_number(s, i)), number).first->second;
        one = std::min(one, number);
      }
    for (const auto& other : s.travelling)
      for (const std::uint32_t i : other.received)
        first[i] = of_id.at(value_of(id_of_number(s, i)));
    auto&& lists = solver_lists<true>(s);
    each_of(lists, [&](auto& list) {
      using list_type = std::remove_reference_t<decltype(list)>;
      if constexpr (requires(list_type & l, std::int32_t(*f)(std::int32_t)) {
                      l.renumber_shared(f);
                    })
        list.renumber_shared([&](std::int32_t i) { return first[static_cast<std::size_t>(i)]; });
    });
  }
}

/// Assigns colours to all contacts of this step, and moves them to their colours.
template <class Scenario>
void colour_contacts(world_state<Scenario>& s) {
  colouring& all = s.colours.all;
  use_single_images(s);
  plain_vector<std::int32_t> line_of;  // of the owner of each body that is a shadow copy
  all.lines.resize(s.travelling.size());
  if (!s.travelling.empty()) line_of.assign(s.solver.bodies.size(), -1);
  for (std::size_t n = 0; n < s.travelling.size(); ++n) {
    all.lines[n].rank = s.travelling[n].rank;
    for (const auto i : s.travelling[n].received) line_of[i] = static_cast<std::int32_t>(n);
  }
  all.start(s.solver.bodies.size());
  plain_vector<std::size_t>& ends = s.colours.ends;
  ends.clear();
  auto&& lists = solver_lists<true>(s);
  each_of(lists, [&](auto& list) {
    list.each_unit([&](contact_unit unit, bool shared) {
      unit.list = static_cast<std::uint32_t>(ends.size());
      if (shared) unit.line = line_of[static_cast<std::size_t>(unit.b)];
      if (shared && unit.line < 0)
        fail<std::runtime_error>(
            "bodies {} and {} touch across ranks in step {}, but rank {} does not hear of the "
            "motion "
            "of one of them: call synchronize() on all ranks after changing bodies",
            text(unit.id_a), text(unit.id_b), s.steps, s.link->rank());
      all.add(unit);
    });
    ends.push_back(all.size());
  });
  all.colour([&](bool first) {
    const stage_clock clock(s.seconds.exchange);
    std::vector<neighbour_message> neighbour_messages;
    for (colour_line& l : all.lines)
      if (first || l.open())
        neighbour_messages.push_back(
            {.rank = l.rank, .out = std::move(l.out), .in = std::move(l.in)});
    s.link->start(neighbour_messages);
    s.link->finish(neighbour_messages);
    std::size_t n = 0;
    for (colour_line& l : all.lines)
      if (first || l.open())
        l.out = std::move(neighbour_messages[n].out), l.in = std::move(neighbour_messages[n].in),
        ++n;
  });
  std::size_t unit = 0;
  const std::size_t* end = ends.data();
  each_of(lists, [&](auto& list) {
    for (; unit < *end; ++unit) list.set_colour(all.unit(unit).first, all.colour_of(unit));
    ++end;
    list.arrange(all.colours(), !all.lines.empty());
  });
}

}  // namespace talus::detail
