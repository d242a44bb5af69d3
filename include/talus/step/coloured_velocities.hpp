#pragma once
// The ghost exchange of solvers that sweep colour by colour; shared_velocities is that of the other
// solvers.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "talus/ghosts/shared_velocities.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Before a colour the velocities travel that the lines of the colour name: mostly those of all
/// bodies of foreign and shared contacts, before the first colour.
template <class Scenario>
class coloured_velocities : public shared_velocities<Scenario> {
  using base = shared_velocities<Scenario>;

 public:
  using base::base;
  static constexpr bool coloured = true;

  [[nodiscard]] std::uint32_t colours() const { return s_.colours.all.colours(); }

  /// From their owners.
  void start_velocities(std::uint32_t colour) {
    start<6, number>(colour, [&](std::size_t i, number* out) {
      const auto& b = s_.solver.bodies[i];
      for (int k = 0; k < 3; ++k) out[k] = b.v[k], out[3 + k] = b.w[k];
    });
  }
  void finish_velocities(std::uint32_t colour) {
    finish<6, number>(colour, [&](std::size_t i, const number* in) {
      auto& b = s_.solver.bodies[i];
      for (int k = 0; k < 3; ++k) b.v[k] = in[k], b.w[k] = in[3 + k];
    });
  }
  /// Sends the position corrections of a colour.
  void start_corrections(std::uint32_t colour) {
    start<base::of_correction, correction>(colour, [&](std::size_t i, correction* out) {
      base::put_correction(static_cast<std::uint32_t>(i), out);
    });
  }
  void finish_corrections(std::uint32_t colour) {
    finish<base::of_correction, correction>(colour, [&](std::size_t i, const correction* in) {
      base::get_correction(static_cast<std::uint32_t>(i), in);
    });
  }

  /// Whether this rank takes part in islands that may be solved exactly after the sweeps.
  [[nodiscard]] bool find_islands() {
    if constexpr (state_type::periodic || state_type::law::soft) return false;
    return s_.exact_islands.find(s_.colours.all, s_.solver);
  }
  /// Before each of the last two sweeps.
  template <class Lists>
  void note_islands(Lists& lists) {
    s_.exact_islands.note_impulses(access_to<solver_type>(lists), s_.solver);
  }
  /// After it.
  template <class Lists>
  void solve_islands(Lists& lists) {
    s_.exact_islands.solve(access_to<solver_type>(lists), s_.solver, exchange_now());
  }

 private:
  using base::s_;
  using typename base::correction;
  using typename base::number;
  using typename base::solver_type;
  using typename base::state_type;

  [[nodiscard]] auto exchange_now() {
    return [this](std::vector<neighbour_message>& messages) {
      const stage_clock clock(s_.seconds.exchange);
      s_.link->start(messages);
      s_.link->finish(messages);
    };
  }
  template <int Scalars, class Real, class Put>
  void start(std::uint32_t colour, Put&& put) {
    auto& m = s_.colours.of_colour[colour];
    if (m.lines.empty()) return;
    const stage_clock clock(s_.seconds.exchange);
    constexpr std::size_t bytes = Scalars * sizeof(Real);
    Real values[Scalars];
    for (std::size_t k = 0; k < m.lines.size(); ++k) {
      const velocities_by_colour& l = s_.colours.lines[m.lines[k]];
      const std::uint32_t first = l.sent_from[colour], last = l.sent_from[colour + 1];
      neighbour_message& p = m.neighbour_messages[k];
      p.out.resize((last - first) * bytes);
      p.in.resize((l.received_from[colour + 1] - l.received_from[colour]) * bytes);
      std::byte* to = p.out.data();
      for (std::uint32_t i = first; i < last; ++i, to += bytes) {
        put(static_cast<std::size_t>(l.sent[i]), values);
        std::memcpy(to, values, bytes);
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
      const velocities_by_colour& l = s_.colours.lines[m.lines[k]];
      const std::byte* from = m.neighbour_messages[k].in.data();
      for (std::uint32_t i = l.received_from[colour]; i < l.received_from[colour + 1];
           ++i, from += bytes) {
        std::memcpy(values, from, bytes);
        get(static_cast<std::size_t>(l.received[i]), values);
      }
    }
  }
};

}  // namespace talus::detail
