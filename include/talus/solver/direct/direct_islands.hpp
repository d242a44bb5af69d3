#pragma once
// Groups of contacts that sweeps do not solve, behind one interface: the code that finds and solves
// them is independent of the scenario and can be compiled once.
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "talus/core/neighbour_message.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/body_ties.hpp"

namespace talus::detail {

/// A sweep over the interior contacts, and then the islands on which sweeps have stalled; see
/// stalled_islands.hpp. Returns whether more sweeps would change nothing of relevance.
template <class State>
bool solve_stalled_islands(std::span<const contact_access<State>> lists, State& s, bool first);

/// The position correction of stacks that were balanced, see support_correction.hpp.
template <class State>
void correct_stacks(std::span<const contact_access<State>> lists, State& s);

/// Islands of contacts across ranks that are solved as one problem each: small ones that several
/// ranks share (shared_islands.hpp), and those around heavy bodies that several ranks touch
/// (gathered_islands.hpp).
template <class State>
class direct_islands {
  using access = contact_access<State>;

 public:
  direct_islands();
  ~direct_islands();
  direct_islands(direct_islands&&) noexcept;
  direct_islands& operator=(direct_islands&&) noexcept;

  // `own` is this rank; `travelling` holds, for each other rank, the bodies with copies there and
  // the copies here of its bodies.

  /// Whether contacts between copies of bodies of other ranks are needed.
  [[nodiscard]] bool wants_foreign_contacts() const;
  /// Before any impulse is applied. `fixed` are the fixed bodies that several ranks know. Without
  /// `shares` this rank takes no part in islands that several ranks solve alike, and sends that
  /// with the ties of its bodies.
  void look(std::span<const access> lists, State& s, int own,
            std::span<const travelling_bodies> travelling, std::span<const fixed_body_ties> fixed,
            bool shares = true);
  /// The ties of a body, for sending and receiving.
  [[nodiscard]] body_ties& ties(std::size_t body);
  [[nodiscard]] bool is_hub(std::uint32_t body) const;
  void add_hub(std::uint32_t body);
  /// After the ties of all bodies have been shared.
  void solve_shared(std::span<const access> lists, State& s);
  /// After the last sweep. `neighbour_messages` becomes one for each other rank that takes part;
  /// `exchange()` sends and receives them.
  void solve_gathered(std::span<const access> lists, State& s, int own,
                      std::span<const travelling_bodies> travelling,
                      std::vector<neighbour_message>& neighbour_messages,
                      const std::function<void()>& exchange);

 private:
  struct parts;
  std::unique_ptr<parts> parts_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/solver/direct/direct_islands_definitions.hpp"
#endif
