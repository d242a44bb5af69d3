#pragma once
// Small groups of contacts on which sweeps make no headway (a heavy body on light ones, a tall
// stack) are solved as one problem.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/response/band_system.hpp"
#include "talus/response/contact_access.hpp"
#include "talus/response/island_problem.hpp"
#include "talus/response/island_solver.hpp"
#include "talus/response/solver_state.hpp"

namespace talus::detail {

/// Finds the islands (contacts connected through bodies that can move) on which the last sweep
/// still changed more than it should, and solves those for which that is cheap. What sweeps leave
/// of an error grows with the ratio of the masses and the square of the bodies in a row: a stack of
/// ten with a top of a thousand times the density needs tens of thousands of sweeps, and one
/// Newton step. Contacts with bodies of other ranks keep their impulses.
template <class State>
class stalled_islands {
  using access = contact_access<State>;

 public:
  /// Whether to look for stalled islands in this step. Where all that stalls is too large to be
  /// solved here, as in a pile, looking is put off for some steps.
  [[nodiscard]] static bool due(State& s) {
    if (s.pause == 0) return true;
    --s.pause;
    return false;
  }

  /// The last sweep, and then what has stalled.
  void sweep_and_solve(std::span<const access> lists, State& s) {
    if (s.speed == 0)  // no gravity
      for (const auto& b : s.bodies) s.speed = std::max(s.speed, 1e-3 * v_of(b).norm());
    // Less cannot matter, or is round-off.
    const real least = (std::is_same_v<typename State::number, real> ? 1e-9 : 1e-5) * s.speed;
    std::size_t stalled = 0, contacts = 0;
    plain_vector<std::span<const std::pair<std::size_t, real>>> changes;
    for (const access& list : lists) {
      changes.emplace_back(list.sweep_watched(s, least));
      stalled += changes.back().size();
      contacts += list.size(contact_part::interior);
    }
    if (stalled == 0) return;
    join_bodies(lists, s);
    gather(lists, changes, s);
    plain_vector<std::pair<real, std::size_t>> worst_first;
    for (const island& one : islands_) worst_first.emplace_back(-one.stall(), worst_first.size());
    sort_values(worst_first);
    real budget = std::max(least_budget, budget_per_contact * static_cast<real>(contacts));
    bool solved = false, looked = false;
    for (const auto& [stall, i] : worst_first)
      if (-stall > let_be * s.speed) {
        looked = true;
        solved |= solve_one(islands_[i], lists, s, budget);
      }
    if (!solved && (looked || stalled > most_contacts)) s.pause = 7;
  }

 private:
  static constexpr std::size_t most_contacts = 1000;
  /// Floating-point operations that a step may spend here: what the sweeps take, or that of a
  /// tall stack.
  static constexpr real least_budget = 2e8, budget_per_contact = 2000;
  /// Of a contact in a sweep, in operations; twice, for a solution is exact.
  static constexpr real sweep_cost = 600;
  /// The part of solver_state::speed that may be left as error.
  static constexpr real let_be = 0.1;

  struct member {
    std::size_t list, index;
  };
  struct island {
    plain_vector<member> contacts;
    std::size_t size = 0;
    real change = 0;  ///< largest change of velocity in the last sweep
    real least_mass = std::numeric_limits<real>::max(), most_mass = 0;
    /// Estimate of the error: each sweep takes one part in (rows² * ratio of masses) from it.
    [[nodiscard]] real stall(real rows) const {
      return change * rows * rows * most_mass / least_mass;
    }
    /// At most: with four contacts in a row.
    [[nodiscard]] real stall() const {
      return size > most_contacts ? 0 : stall(1 + 0.25 * static_cast<real>(size));
    }
  };

  static const auto& body(const State& s, std::int32_t i) {
    return s.bodies[static_cast<std::size_t>(i)];
  }
  static bool moves(const State& s, std::int32_t i) { return body(s, i).inverse_mass != 0; }

  [[nodiscard]] std::uint32_t root(std::int32_t of) {
    auto i = static_cast<std::uint32_t>(of);
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  [[nodiscard]] std::uint32_t root(const contact_ends& c, const State& s) {
    return root(moves(s, c.a) ? c.a : c.b);
  }
  void join_bodies(std::span<const access> lists, const State& s) {
    parent_.resize(s.bodies.size());
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    for (const access& list : lists)
      for (std::size_t i = 0, n = list.size(contact_part::interior); i < n; ++i) {
        const auto [a, b] = list.ends(contact_part::interior, i);
        if (b < 0 || !moves(s, a) || !moves(s, b)) continue;
        const auto x = root(a), y = root(b);
        if (x != y) parent_[std::max(x, y)] = std::min(x, y);
      }
  }
  void gather(std::span<const access> lists,
              std::span<const std::span<const std::pair<std::size_t, real>>> changes,
              const State& s) {
    islands_.clear();
    number_.assign(s.bodies.size(), 0);  // from 1, of the island of a root
    for (std::size_t k = 0; k < lists.size(); ++k)
      for (const auto& [i, change] : changes[k]) {
        auto& number = number_[root(lists[k].ends(contact_part::interior, i), s)];
        if (number == 0) {
          islands_.emplace_back();
          number = static_cast<std::uint32_t>(islands_.size());
        }
        island& one = islands_[number - 1];
        one.change = std::max(one.change, change);
      }
    for (std::size_t k = 0; k < lists.size(); ++k)
      for (std::size_t i = 0, n = lists[k].size(contact_part::interior); i < n; ++i) {
        const contact_ends c = lists[k].ends(contact_part::interior, i);
        const auto number = number_[root(c, s)];
        if (number == 0) continue;
        island& one = islands_[number - 1];
        if (one.size++ >= most_contacts) continue;
        one.contacts.push_back({k, i});
        for (const std::int32_t end : {c.a, c.b})
          if (end >= 0 && moves(s, end)) {
            const real mass = 1 / real(body(s, end).inverse_mass);
            one.least_mass = std::min(one.least_mass, mass);
            one.most_mass = std::max(one.most_mass, mass);
          }
      }
  }

  /// Whether the island, now that its length is known, is stalled and could be afforded.
  static bool solve_one(const island& one, std::span<const access> lists, State& s, real& budget) {
    plain_vector<island_contact> contacts;
    for (const member& m : one.contacts)
      contacts.push_back(lists[m.list].contact(contact_part::interior, m.index));
    plain_vector<island_contact> ties = contacts;  // immovable bodies tie nothing together
    for (island_contact& c : ties)
      for (std::int32_t* end : {&c.a, &c.b})
        if (*end >= 0 && !moves(s, *end)) *end = -1;
    const contact_order order(ties);
    const real rows = 1 + static_cast<real>(order.length());
    if (one.stall(rows) <= let_be * s.speed) return false;
    const real cost = band_system::cost(contacts.size(), order.half_bandwidth());
    // Not where the sweeps that it stands for cost less, as in heaps that are wide.
    const real sweeps = rows * rows * one.most_mass / one.least_mass;
    if (cost > budget / 2 || cost > sweep_cost * sweeps * static_cast<real>(contacts.size()))
      return false;
    plain_vector<island_contact> chain;
    for (const auto i : order.order()) chain.push_back(contacts[i]);
    contact_vector r;
    const assembled_problem problem = assemble_island(chain, s, r);
    budget -= cost * solve_island(problem, r, static_cast<int>(budget / cost));
    for (std::size_t k = 0; k < chain.size(); ++k) {
      const member& m = one.contacts[order.order()[k]];
      lists[m.list].set(m.index, chain[k].axes.transpose() * r(static_cast<int>(k)), s);
    }
    return true;
  }

  plain_vector<std::uint32_t> parent_, number_;
  std::vector<island> islands_;
};

}  // namespace talus::detail
