#pragma once
// Small groups of contacts on which sweeps stall (a heavy body on light ones, a tall stack) are
// solved as one problem.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "talus/constraint/solver_state.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/band_system.hpp"
#include "talus/solver/direct/body_problem.hpp"
#include "talus/solver/direct/clusters.hpp"
#include "talus/solver/direct/island_problem.hpp"
#include "talus/solver/direct/island_solver.hpp"
#include "talus/solver/direct/isolated_island.hpp"
#include "talus/solver/direct/solve_bodies.hpp"
#include "talus/solver/direct/support_balance.hpp"

namespace talus::detail {

/// Finds the islands (contacts connected through movable bodies) on which the last sweep still
/// changed more than it should, and solves those that are cheap to solve. The error that sweeps
/// leave grows with the ratio of the masses and the square of the bodies in a row: a stack of ten
/// with a top of a thousand times the density needs tens of thousands of sweeps, and one Newton
/// step; so does a plate on thousands of spheres. Contacts with bodies of other ranks keep their
/// impulses.
template <class State>
class stalled_islands {
  using access = contact_access<State>;

 public:
  /// A sweep, and then the stalled islands. If all of them are too large to be solved here, as in a
  /// pile, the search is postponed for some steps. Returns whether more sweeps would change nothing
  /// of relevance. A `first` sweep ends with that if it is so with the islands of the last search.
  bool sweep_and_solve(std::span<const access> lists, State& s, bool first) {
    if (s.speed == 0)  // no gravity
      for (const auto& b : s.bodies) s.speed = std::max(s.speed, 1e-3 * v_of(b).norm());
    // A smaller change is irrelevant, or is round-off.
    const real least = (std::is_same_v<typename State::number, real> ? 1e-9 : 1e-5) * s.speed;
    std::size_t stalled = 0, contacts = 0;
    real most = 0;
    plain_vector<std::span<const plain_pair<std::size_t, real>>> changes;
    for (const access& list : lists) {
      changes.emplace_back(list.sweep_watched(s, least));
      stalled += changes.back().size();
      contacts += list.size(contact_part::interior);
      for (const auto& [i, change] : changes.back()) most = std::max(most, change);
    }
    if (stalled == 0 && !first) s.islands.forget_errors();
    if (stalled == 0) return true;
    if (first && most * s.islands.errors_per_change() <= negligible * s.speed) return true;
    join_bodies(lists, s);
    gather(lists, changes, s);
    plain_vector<plain_pair<real, std::size_t>> worst_first;
    for (const island& one : islands_)
      worst_first.emplace_back(is_solved_here(one) ? -one.error() : 0, worst_first.size());
    sort_values(worst_first);
    double budget = s.islands.open(contacts);
    bool solved = false, searched_at = false;
    for (const bool clusters : {false, true})  // not of islands that are solved as a whole
      for (const auto& [stall, i] : worst_first) {
        island& one = islands_[i];
        if (one.is_cluster() != clusters ||
            -stall <= (one.sweeps_do() ? negligible : let_be) * s.speed)
          continue;
        if (clusters && islands_[one.within].done) continue;
        searched_at |= !one.sweeps_do();
        one.done =
            one.sweeps_do() ? balance_large(one, lists, s) : solve_one(one, lists, s, budget);
        solved |= one.done;
        if (island& all = islands_[clusters ? one.within : i]; all.size == one.size)
          all.done = one.done;
      }
    bool settled = true;
    real errors = 0;
    for (const island& one : islands_) {
      errors = std::max(errors, one.error_per_change());
      settled = settled && (one.done || one.error() <= negligible * s.speed);
    }
    s.islands.note_errors(errors);
    s.islands.close(budget);
    if (!solved && !settled && (searched_at || stalled > many)) s.islands.pause();
    return settled;
  }

 private:
  /// Larger islands are not solved as a whole, unless their bodies can rest on each other: sweeps
  /// work well, as in a pile.
  static constexpr std::size_t many = 1000;
  /// Of a contact in a sweep, in operations; twice, because a solution is exact.
  static constexpr real sweep_cost = 600;
  /// The fraction of an error that a solution may leave where Newton's method can find a better
  /// one.
  static constexpr real exact = 1e-9;
  /// Bodies that can rest on each other are not faster than this multiple of solver_state::speed.
  static constexpr real fast = 10;
  /// Rows through which the sweeps of the position correction do not carry.
  static constexpr int tall = 8;
  /// Contacts of islands that are solved in each step in which they stall. Of larger ones only the
  /// clusters of heavy bodies on light ones are, unless the island is narrow or rests.
  static constexpr std::size_t small = 64;
  /// Cheaper islands are solved by contacts, which is as good for a few.
  static constexpr real few = 4e6;
  /// The fraction of solver_state::speed that may be left as error.
  static constexpr real let_be = 0.1;
  /// The same that needs no more sweeps, and no balance.
  static constexpr real negligible = 1e-4;

  static constexpr std::uint32_t none = overloaded_clusters::none;

  struct member {
    std::size_t list, index;
  };
  struct island {
    std::size_t size = 0, end = 0;  ///< number of its contacts, and their end in `members_`
    std::uint32_t within = none;    ///< the island of a cluster
    std::uint32_t cluster = none;
    bool overloaded = false;  ///< sweeps fail: a cluster, or a small island with one
    bool jointed = false;     ///< contains bodies with joints
    bool elsewhere = false;   ///< solved as a part of a gathered island
    bool done = false;        ///< is solved
    real change = 0;          ///< largest change of velocity in the last sweep
    real least_mass = std::numeric_limits<real>::max(), most_mass = 0;
    real rows = 0;  ///< contacts or bodies in a row; 0 if unknown
    /// Each sweep removes one part in (rows² * ratio of masses) of the error. Without knowing the
    /// rows, an upper limit: with four contacts in a row.
    [[nodiscard]] real error_per_change() const {
      const real all = rows > 0 ? rows : 1 + 0.25 * static_cast<real>(size);
      return all * all * most_mass / least_mass;
    }
    [[nodiscard]] real error() const { return change * error_per_change(); }
    [[nodiscard]] bool is_cluster() const { return within != none; }
    [[nodiscard]] bool sweeps_do() const { return size > many && !is_cluster(); }
    void add(real mass) {
      least_mass = std::min(least_mass, mass), most_mass = std::max(most_mass, mass);
    }
  };

  static const auto& body(const State& s, std::int32_t i) {
    return s.bodies[static_cast<std::size_t>(i)];
  }
  static bool moves(const State& s, std::int32_t i) { return body(s, i).inverse_mass != 0; }

  [[nodiscard]] std::uint32_t root(const contact_ends& c, const State& s) {
    return sets_.root(moves(s, c.a) ? c.a : c.b);
  }
  void join_bodies(std::span<const access> lists, const State& s) {
    sets_.reset(s.bodies.size());
    ends_.clear(), firsts_.clear();
    for (const access& list : lists) {
      firsts_.push_back(ends_.size());
      for (std::size_t i = 0, n = list.size(contact_part::interior); i < n; ++i) {
        ends_.push_back(list.ends(contact_part::interior, i));
        const auto [a, b] = ends_.back();
        if (b < 0 || !moves(s, a) || !moves(s, b)) continue;
        sets_.join(a, b);
      }
    }
    firsts_.push_back(ends_.size());
  }
  void gather(std::span<const access> lists,
              std::span<const std::span<const plain_pair<std::size_t, real>>> changes,
              const State& s) {
    islands_.clear();
    number_.assign(s.bodies.size(), 0);  // from 1, of the island of a root
    for (std::size_t k = 0; k < lists.size(); ++k)
      for (const auto& [i, change] : changes[k]) {
        auto& number = number_[root(ends_[firsts_[k] + i], s)];
        if (number == 0) {
          islands_.emplace_back();
          number = static_cast<std::uint32_t>(islands_.size());
        }
        island& one = islands_[number - 1];
        one.change = std::max(one.change, change);
      }
    island_of_.resize(ends_.size());
    for (std::size_t n = 0; n < ends_.size(); ++n) island_of_[n] = number_[root(ends_[n], s)];
    masses_.resize(s.bodies.size());
    for (std::size_t i = 0; i < s.bodies.size(); ++i)
      masses_[i] = s.bodies[i].inverse_mass != 0 ? 1 / real(s.bodies[i].inverse_mass) : 0;
    each_contact([&](island& one, const contact_ends& c, std::size_t) {
      ++one.size;
      for (const std::int32_t end : {c.a, c.b})
        if (end >= 0 && moves(s, end)) one.add(mass_of(end));
    });
    for (const std::uint32_t i : s.gathered)
      if (const auto number = number_[sets_.root(i)]; number != 0)
        islands_[number - 1].elsewhere = true;
    for (const std::uint32_t i : s.jointed)
      if (i < s.bodies.size())
        if (const auto number = number_[sets_.root(i)]; number != 0)
          islands_[number - 1].jointed = true;
    find_clusters(changes);
    balances_ = s.fall != vec3(0, 0, 0) && s.islands.balances();
    std::size_t members = 0;
    for (island& one : islands_) {
      if (is_solved_here(one)) members += one.size;
      one.end = members;
    }
    members_.resize(members);
    for (island& one : islands_)
      if (is_solved_here(one)) one.end -= one.size;
    const auto add = [&](island& one, std::size_t n) {
      if (is_solved_here(one)) members_[one.end++] = n;
    };
    each_contact([&](island& one, const contact_ends&, std::size_t n) { add(one, n); });
    each_of_clusters([&](island& one, std::size_t n) { add(one, n); });
    numbers_.assign(s.bodies.size(), -1);
  }
  [[nodiscard]] bool is_solved_here(const island& one) const {
    return !one.elsewhere && (balances_ || !one.sweeps_do());
  }
  /// Calls f(island, ends, contact) for each contact of the islands.
  template <class F>
  void each_contact(F&& f) {
    for (std::size_t n = 0; n < ends_.size(); ++n)
      if (const auto number = island_of_[n]; number != 0) f(islands_[number - 1], ends_[n], n);
  }
  /// Calls f(cluster, contact) for each contact of the clusters that stall.
  template <class F>
  void each_of_clusters(F&& f) {
    if (!clusters_.found()) return;
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      if (island_of_[n] == 0) continue;
      const std::uint32_t a = cluster_at(ends_[n].a), b = cluster_at(ends_[n].b);
      if (a != none) f(islands_[a], n);
      if (b != none && b != a) f(islands_[b], n);
    }
  }
  /// Its number among the islands.
  [[nodiscard]] std::uint32_t cluster_at(std::int32_t body) {
    const std::uint32_t of = clusters_.of(body);
    return of == none ? none : cluster_number_[of];
  }
  void find_clusters(std::span<const std::span<const plain_pair<std::size_t, real>>> changes) {
    const auto in_question = [&](std::size_t n) {
      const std::uint32_t number = island_of_[n];
      return number != 0 && !islands_[number - 1].elsewhere;
    };
    clusters_.find(ends_, in_question, masses_);
    if (!clusters_.found()) return;
    cluster_number_.assign(masses_.size(), none);
    for (std::size_t k = 0; k < changes.size(); ++k)
      for (const auto& [i, change] : changes[k]) {
        const std::size_t n = firsts_[k] + i;
        for (const std::int32_t end : {ends_[n].a, ends_[n].b}) {
          const std::uint32_t of = clusters_.of(end);
          if (of == none) continue;
          const std::uint32_t within = island_of_[n] - 1;
          islands_[within].overloaded |= islands_[within].size <= small;
          if (islands_[within].overloaded) continue;  // is solved as a whole
          std::uint32_t& number = cluster_number_[of];
          if (number == none) {
            number = static_cast<std::uint32_t>(islands_.size());
            islands_.push_back({.within = within,
                                .cluster = of,
                                .overloaded = true,
                                .jointed = islands_[within].jointed});
          }
          islands_[number].change = std::max(islands_[number].change, change);
        }
      }
    each_of_clusters([&](island& one, std::size_t n) {
      ++one.size;
      for (const std::int32_t end : {ends_[n].a, ends_[n].b})
        if (clusters_.of(end) == one.cluster) one.add(mass_of(end));
    });
  }
  [[nodiscard]] real mass_of(std::int32_t i) const { return masses_[static_cast<std::size_t>(i)]; }

  [[nodiscard]] std::span<const std::size_t> members_of(const island& one) const {
    return {members_.data() + (one.end - one.size), one.size};
  }
  /// Where a contact is.
  [[nodiscard]] member place_of(std::size_t n) const {
    std::size_t list = 0;
    while (n >= firsts_[list + 1]) ++list;
    return {list, n - firsts_[list]};
  }
  void set(std::size_t n, const vec3& impulse, std::span<const access> lists, State& s) const {
    const member m = place_of(n);
    lists[m.list].set(m.index, impulse, s);
  }
  [[nodiscard]] isolated_island isolate(const island& one, std::span<const access> lists,
                                        const State& s) {
    plain_vector<island_contact> contacts;
    contacts.reserve(one.size);
    for (const std::size_t n : members_of(one)) {
      const member m = place_of(n);
      contacts.push_back(lists[m.list].contact(contact_part::interior, m.index));
    }
    isolated_island alone(std::move(contacts), s, numbers_);
    if (one.is_cluster())
      for (std::size_t k = 0; k < alone.bodies.size(); ++k)
        if (clusters_.of(static_cast<std::int32_t>(alone.bodies[k])) != one.cluster)
          alone.state.bodies[k].inverse_mass = 0;  // carries the cluster
    return alone;
  }
  enum class outcome : char { not_stalled, failed, done };
  /// Lets the bodies of an island rest on each other, if so many are above each other that sweeps
  /// stall, and if they can.
  /// More than the fraction `left` of the error is a failure.
  outcome balance(island& one, const isolated_island& alone, real left,
                  std::span<const access> lists, State& s) const {
    support_balance balance(alone.contacts, alone.state);
    one.rows = static_cast<real>(balance.rows());
    if (one.error() <= negligible * s.speed) return outcome::not_stalled;
    const bool solved = balance.solve(1e-12 * s.speed, fast * s.speed, left == exact) <= left;
    if (balance.rows() >= tall) s.islands.note_stack(solved);
    if (!solved) return outcome::failed;
    s.islands.solved();
    const auto members = members_of(one);
    for (std::size_t k = 0; k < members.size(); ++k)
      if (balance.changes(k)) set(members[k], balance.impulse(k), lists, s);
    return outcome::done;
  }
  /// The same for a large island. Further attempts are postponed unless it succeeds.
  bool balance_large(island& one, std::span<const access> lists, State& s) {
    const outcome found = balance(one, isolate(one, lists, s), 0.5, lists, s);
    if (found == outcome::done) s.islands.balanced();
    if (found == outcome::failed) s.islands.not_balanced();
    if (found == outcome::not_stalled) s.islands.need_no_balance();
    return found == outcome::done;
  }
  /// Whether the island, with its known length, is stalled and within the budget.
  bool solve_one(island& one, std::span<const access> lists, State& s, double& budget) {
    const isolated_island alone = isolate(one, lists, s);
    const plain_vector<island_contact>& contacts = alone.contacts;
    const contact_order order(contacts, alone.state);
    const real rows = one.rows = 1 + static_cast<real>(order.length());
    if (one.error() <= let_be * s.speed) return false;
    const real cost = band_system::cost(contacts.size(), order.half_bandwidth());
    const real sweeps = rows * rows * one.most_mass / one.least_mass;
    // Not if the sweeps that it replaces cost less, as in wide heaps.
    const real pays = sweep_cost * sweeps * static_cast<real>(contacts.size());
    // The joints move what was solved here, so that it stalls again.
    const bool fails = one.overloaded && !one.jointed;
    double left = std::min<double>(fails ? budget : s.islands.spare(), pays);
    const double before = left;
    const auto spend = [&](double used) {
      if (fails)
        budget -= used;
      else
        s.islands.spend_spare(used);
    };
    if (cost <= std::min<real>(few, left / 2)) {
      solve_by_contacts(one, alone, order, cost, lists, s, left);
      spend(before - left);
      s.islands.solved();
      return true;
    }
    if (s.fall != vec3(0, 0, 0) && balance(one, alone, exact, lists, s) == outcome::done)
      return true;
    one.rows = rows;
    if (contacts.size() > small && !one.is_cluster()) return false;
    if (left < body_newton::per_contact * static_cast<real>(contacts.size())) return false;
    contact_vector r;
    const body_problem problem(contacts, alone.state, r);
    const island_outcome found = solve_by_bodies(problem, r, left);
    spend(before - left);
    if (fails && found.too_dear && !found.solved && pays > before) s.islands.skip(contacts.size());
    if (!(found.after < found.before)) return found.solved;
    s.islands.solved();
    const auto members = members_of(one);
    for (std::size_t k = 0; k < members.size(); ++k)
      set(members[k], contacts[k].axes.transpose() * r(static_cast<int>(k)), lists, s);
    return found.after < 0.5 * found.before;
  }
  void solve_by_contacts(const island& one, const isolated_island& alone,
                         const contact_order& order, real cost, std::span<const access> lists,
                         State& s, double& budget) const {
    plain_vector<island_contact> chain;
    for (const auto i : order.order()) chain.push_back(alone.contacts[i]);
    contact_vector r;
    const assembled_problem problem = assemble_island(chain, alone.state, r);
    budget -= cost * solve_island(problem, r, static_cast<int>(budget / cost));
    for (std::size_t k = 0; k < chain.size(); ++k)
      set(members_of(one)[order.order()[k]], chain[k].axes.transpose() * r(static_cast<int>(k)),
          lists, s);
  }

  disjoint_sets sets_;
  plain_vector<contact_ends> ends_;        ///< of the contacts of all lists
  plain_vector<std::size_t> firsts_;       ///< of each list, and the end
  plain_vector<std::uint32_t> island_of_;  ///< of each contact, from 1
  plain_vector<std::uint32_t> number_;     ///< the same of a root
  plain_vector<real> masses_;              ///< of the bodies that can move
  plain_vector<island> islands_;
  plain_vector<std::size_t> members_;  ///< the contacts of each island that is solved here
  overloaded_clusters clusters_;
  plain_vector<std::uint32_t> cluster_number_;  ///< among the islands, of a number of clusters_
  plain_vector<std::int32_t> numbers_;          ///< of bodies, for isolated_island
  bool balances_ = false;                       ///< large islands, too
};

}  // namespace talus::detail
