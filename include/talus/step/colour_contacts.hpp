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
#include "talus/step/kept_contacts.hpp"

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

/// The colours of all contacts of this step, and their order in memory by colour.
template <class Scenario>
class contact_colours {
  using state = world_state<Scenario>;
  static constexpr bool may_keep = keeps_first_contacts<Scenario>();

 public:
  explicit contact_colours(state& s) : s_(s), all_(s.colours.all), ends_(s.colours.ends) {}

  /// Assigns colours, and moves the contacts to them.
  void assign() {
    use_single_images(s_);
    auto&& lists = solver_lists<true>(s_);
    const std::size_t kept = kept_units();
    if (kept > 0 && others_are_the_same(lists)) return arrange_from(lists, 1);
    if (kept > 0) {
      const plain_vector<std::uint32_t> before = colours_of_first(kept);
      collect(lists, kept);
      all_.colour([](bool) {});
      if constexpr (may_keep)
        first().rearrange(
            before, [&](std::size_t n) { return all_.colour_of(n); }, all_.colours());
      return arrange_from(lists, 1);
    }
    note_lines();
    collect(lists, 0);
    all_.colour([&](bool first) { exchange(first); });
    arrange_from(lists, 0);
    if constexpr (may_keep)
      if (first().lacks_data()) contact_keeper<Scenario, true>(s_).set_data();
  }

 private:
  [[nodiscard]] auto& first() { return list_in_use<true>(std::get<0>(s_.contacts)); }
  /// The number of contacts that have the colours of the last step.
  [[nodiscard]] std::size_t kept_units() {
    if constexpr (may_keep)
      if (s_.on_one_rank() && first().renewed()) return first().size();
    return 0;
  }
  [[nodiscard]] plain_vector<std::uint32_t> colours_of_first(std::size_t kept) const {
    return plain_vector<std::uint32_t>(all_.colours_of_units().first(kept));
  }
  /// Whether all lists but the first one have the units of the last step.
  template <class Lists>
  [[nodiscard]] bool others_are_the_same(Lists& lists) const {
    std::size_t n = ends_[0], list = 0;
    bool same = true;
    each_of(lists, [&](auto& l) {
      if (list > 0) {
        l.each_unit([&](const contact_unit& u, bool) {
          same = same && n < ends_[list] && all_.unit(n).same_bodies(u);
          ++n;
        });
        same = same && n == ends_[list];
      }
      ++list;
    });
    return same;
  }
  /// Which neighbour has each body that is a shadow copy.
  void note_lines() {
    all_.lines.resize(s_.travelling.size());
    if (!s_.travelling.empty()) line_of_.assign(s_.solver.bodies.size(), -1);
    for (std::size_t n = 0; n < s_.travelling.size(); ++n) {
      all_.lines[n].rank = s_.travelling[n].rank;
      for (const auto i : s_.travelling[n].received) line_of_[i] = static_cast<std::int32_t>(n);
    }
  }
  /// The units of all lists; those of the first one are the first `kept` of the last step, if any.
  template <class Lists>
  void collect(Lists& lists, std::size_t kept) {
    all_.start(s_.solver.bodies.size(), kept);
    ends_.clear();
    each_of(lists, [&](auto& list) {
      if (kept == 0 || !ends_.empty())
        list.each_unit([&](contact_unit unit, bool shared) {
          unit.list = static_cast<std::uint32_t>(ends_.size());
          if (shared) unit.line = line_of_[static_cast<std::size_t>(unit.b)];
          if (shared && unit.line < 0)
            fail<std::runtime_error>(
                "bodies {} and {} touch across ranks in step {}, but rank {} does not hear of the "
                "motion "
                "of one of them: call synchronize() on all ranks after changing bodies",
                text(unit.id_a), text(unit.id_b), s_.steps, s_.link->rank());
          all_.add(unit);
        });
      ends_.push_back(all_.size());
    });
  }
  void exchange(bool first) {
    const stage_clock clock(s_.seconds.exchange);
    std::vector<neighbour_message> neighbour_messages;
    for (colour_line& l : all_.lines)
      if (first || l.open())
        neighbour_messages.push_back(
            {.rank = l.rank, .out = std::move(l.out), .in = std::move(l.in)});
    s_.link->start(neighbour_messages);
    s_.link->finish(neighbour_messages);
    std::size_t n = 0;
    for (colour_line& l : all_.lines)
      if (first || l.open())
        l.out = std::move(neighbour_messages[n].out), l.in = std::move(neighbour_messages[n].in),
        ++n;
  }
  /// Moves the contacts of all lists from number `begin` on to their colours.
  template <class Lists>
  void arrange_from(Lists& lists, std::size_t begin) {
    std::size_t unit = begin == 0 ? 0 : ends_[begin - 1], list = 0;
    each_of(lists, [&](auto& l) {
      if (list >= begin) {
        for (; unit < ends_[list]; ++unit)
          l.set_colour(all_.unit(unit).first, all_.colour_of(unit));
        l.arrange(all_.colours(), !all_.lines.empty());
      }
      ++list;
    });
  }

  state& s_;
  colouring& all_;
  plain_vector<std::size_t>& ends_;  ///< of the lists, among the units
  plain_vector<std::int32_t> line_of_;
};

}  // namespace talus::detail
