#pragma once
// Islands that each of their ranks solves alike, for solvers by colours, behind one interface: the
// code that finds and solves them is independent of the scenario and can be compiled once.
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "talus/core/neighbour_message.hpp"
#include "talus/solver/colouring.hpp"
#include "talus/solver/contact_access.hpp"

namespace talus::detail {

/// See exact_islands.hpp.
template <class State>
class islands_by_colours {
  using access = contact_access<State>;

 public:
  islands_by_colours();
  ~islands_by_colours();
  islands_by_colours(islands_by_colours&&) noexcept;
  islands_by_colours& operator=(islands_by_colours&&) noexcept;

  using exchange_type = std::function<void(std::vector<neighbour_message>&)>;
  /// Before the sweeps; returns whether this rank takes part in any.
  bool find(colouring& pairs, const State& s);
  /// Before each of the last two sweeps.
  void note_impulses(std::span<const access> lists, const State& s);
  /// After the last sweep; `exchange(messages)` sends and receives messages of neighbours.
  void solve(std::span<const access> lists, State& s, const exchange_type& exchange);

 private:
  struct parts;
  std::unique_ptr<parts> parts_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/solver/direct/islands_by_colours_definitions.hpp"
#endif
