#pragma once
// The definitions of direct_islands.hpp, in the compiled part or in each program.
#include "talus/solver/direct/direct_islands.hpp"
#include "talus/solver/direct/gathered_islands.hpp"
#include "talus/solver/direct/shared_islands.hpp"
#include "talus/solver/direct/stalled_islands.hpp"
#include "talus/solver/direct/support_correction.hpp"

namespace talus::detail {

template <class State>
bool solve_stalled_islands(std::span<const contact_access<State>> lists, State& s, bool first) {
  return stalled_islands<State>::sweep_and_solve(lists, s, first);
}

template <class State>
void correct_stacks(std::span<const contact_access<State>> lists, State& s) {
  correct_stacks_here(lists, s);
}

template <class State>
struct direct_islands<State>::parts {
  shared_islands<State> shared;
  gathered_islands<State> gathered;
};

template <class State>
direct_islands<State>::direct_islands() : parts_(std::make_unique<parts>()) {}
template <class State>
direct_islands<State>::~direct_islands() = default;
template <class State>
direct_islands<State>::direct_islands(direct_islands&&) noexcept = default;
template <class State>
direct_islands<State>& direct_islands<State>::operator=(direct_islands&&) noexcept = default;

template <class State>
bool direct_islands<State>::wants_foreign_contacts() const {
  return parts_->shared.wanted();
}
template <class State>
void direct_islands<State>::look(std::span<const access> lists, State& s, int own,
                                 std::span<const travelling_bodies> travelling,
                                 std::span<const fixed_body_ties> fixed, bool shares) {
  parts_->shared.look(lists, s, own, travelling, fixed, shares);
  parts_->gathered.find_hubs(lists, s, own, travelling);
}
template <class State>
body_ties& direct_islands<State>::ties(std::size_t body) {
  return parts_->shared.ties(body);
}
template <class State>
bool direct_islands<State>::is_hub(std::uint32_t body) const {
  return parts_->gathered.is_hub(body);
}
template <class State>
void direct_islands<State>::add_hub(std::uint32_t body) {
  parts_->gathered.add_hub(body);
}
template <class State>
void direct_islands<State>::solve_shared(std::span<const access> lists, State& s) {
  parts_->shared.solve(lists, s);
  parts_->gathered.mark(lists, s);
}
template <class State>
void direct_islands<State>::solve_gathered(std::span<const access> lists, State& s, int own,
                                           std::span<const travelling_bodies> travelling,
                                           std::vector<neighbour_message>& neighbour_messages,
                                           const std::function<void()>& exchange) {
  parts_->gathered.solve(lists, s, own, travelling, neighbour_messages, exchange);
}

}  // namespace talus::detail
