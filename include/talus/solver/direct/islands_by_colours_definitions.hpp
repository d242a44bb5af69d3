#pragma once
// The definitions of islands_by_colours.hpp, in the compiled part or in each program.
#include "talus/solver/direct/exact_islands.hpp"
#include "talus/solver/direct/islands_by_colours.hpp"

namespace talus::detail {

template <class State>
struct islands_by_colours<State>::parts {
  exact_islands<State> islands;
};

template <class State>
islands_by_colours<State>::islands_by_colours() : parts_(std::make_unique<parts>()) {}
template <class State>
islands_by_colours<State>::~islands_by_colours() = default;
template <class State>
islands_by_colours<State>::islands_by_colours(islands_by_colours&&) noexcept = default;
template <class State>
islands_by_colours<State>& islands_by_colours<State>::operator=(islands_by_colours&&) noexcept =
    default;

template <class State>
bool islands_by_colours<State>::find(colouring& pairs, const State& s) {
  return parts_->islands.find(pairs, s);
}
template <class State>
void islands_by_colours<State>::note_impulses(std::span<const access> lists, const State& s) {
  parts_->islands.note_impulses(lists, s);
}
template <class State>
void islands_by_colours<State>::solve(std::span<const access> lists, State& s,
                                      const exchange_type& exchange) {
  parts_->islands.solve(lists, s, exchange);
}

}  // namespace talus::detail
