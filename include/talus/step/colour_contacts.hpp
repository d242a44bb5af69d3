#pragma once
// How ranks agree on the colours of contacts, and refresh the velocities of shadow copies before
// each colour that needs them. For solvers that sweep colour by colour.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "talus/ghosts/shared_velocities.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Assigns colours to all contacts of this step, and moves them to their colours.
template <class Scenario>
void colour_contacts(world_state<Scenario>& s) {
  colouring& all = s.colours.all;
  plain_vector<std::int32_t> line_of;  // of the owner of each body that is a shadow copy
  all.lines.resize(s.travelling.size());
  if (!s.travelling.empty()) line_of.assign(s.solver.bodies.size(), -1);
  for (std::size_t n = 0; n < s.travelling.size(); ++n) {
    all.lines[n].rank = s.travelling[n].rank;
    for (const auto i : s.travelling[n].received) line_of[i] = static_cast<std::int32_t>(n);
  }
  all.start(s.solver.bodies.size());
  plain_vector<std::size_t> ends;  // of the lists, among the units
  auto&& lists = solver_lists<true>(s);
  each_of(lists, [&](const auto& list) {
    list.each_unit([&](contact_unit unit, bool shared) {
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
    list.arrange(all.colours());
  });

  auto& of_colour = s.colours.of_colour;
  if (of_colour.size() < all.colours()) of_colour.resize(all.colours());
  for (std::uint32_t c = 0; c < all.colours(); ++c) {
    auto& m = of_colour[c];
    m.lines.clear();
    for (std::size_t n = 0; n < all.lines.size(); ++n)
      if (all.lines[n].first[c + 1] > all.lines[n].first[c])
        m.lines.push_back(static_cast<std::uint32_t>(n));
    m.neighbour_messages.resize(m.lines.size());
    for (std::size_t k = 0; k < m.lines.size(); ++k)
      m.neighbour_messages[k].rank = all.lines[m.lines[k]].rank;
  }
}

/// The ghost exchange of solvers by colours; shared_velocities is that of the other solvers.
template <class Scenario>
class coloured_velocities : public shared_velocities<Scenario> {
  using base = shared_velocities<Scenario>;

 public:
  using base::base;
  static constexpr bool coloured = true;

  [[nodiscard]] std::uint32_t colours() const { return s_.colours.all.colours(); }

  /// Velocities of the bodies of shared contacts of a colour, from their owners.
  void start_velocities(std::uint32_t colour) {
    start<6, number>(colour, [&](std::uint32_t i, number* out) { base::put_velocity(i, out); });
  }
  void finish_velocities(std::uint32_t colour) {
    finish<6, number>(colour,
                      [&](std::uint32_t i, const number* in) { base::get_velocity(i, in); });
  }
  /// Likewise the position corrections.
  void start_corrections(std::uint32_t colour) {
    start<base::of_correction, correction>(
        colour, [&](std::uint32_t i, correction* out) { base::put_correction(i, out); });
  }
  void finish_corrections(std::uint32_t colour) {
    finish<base::of_correction, correction>(
        colour, [&](std::uint32_t i, const correction* in) { base::get_correction(i, in); });
  }

 private:
  using base::s_;
  using typename base::correction;
  using typename base::number;

  template <int Scalars, class Real, class Put>
  void start(std::uint32_t colour, Put&& put) {
    auto& m = s_.colours.of_colour[colour];
    if (m.lines.empty()) return;
    const stage_clock clock(s_.seconds.exchange);
    constexpr std::size_t bytes = Scalars * sizeof(Real);
    Real values[Scalars];
    for (std::size_t k = 0; k < m.lines.size(); ++k) {
      const colour_line& l = s_.colours.all.lines[m.lines[k]];
      const std::uint32_t first = l.first[colour], count = l.first[colour + 1] - first;
      m.neighbour_messages[k].out.resize(count * bytes),
          m.neighbour_messages[k].in.resize(count * bytes);
      for (std::uint32_t u = 0; u < count; ++u) {
        put(static_cast<std::uint32_t>(l.own[first + u]), values);
        std::memcpy(m.neighbour_messages[k].out.data() + u * bytes, values, bytes);
      }
    }
    s_.link->start_fixed(m.neighbour_messages);
  }
  template <int Scalars, class Real, class Get>
  void finish(std::uint32_t colour, Get&& get) {
    auto& m = s_.colours.of_colour[colour];
    if (m.lines.empty()) return;
    const stage_clock clock(s_.seconds.exchange);
    constexpr std::size_t bytes = Scalars * sizeof(Real);
    s_.link->finish_fixed(m.neighbour_messages);
    Real values[Scalars];
    for (std::size_t k = 0; k < m.lines.size(); ++k) {
      const colour_line& l = s_.colours.all.lines[m.lines[k]];
      const std::uint32_t first = l.first[colour], count = l.first[colour + 1] - first;
      for (std::uint32_t u = 0; u < count; ++u) {
        std::memcpy(values, m.neighbour_messages[k].in.data() + u * bytes, bytes);
        get(static_cast<std::uint32_t>(l.foreign[first + u]), values);
      }
    }
  }
};

}  // namespace talus::detail
