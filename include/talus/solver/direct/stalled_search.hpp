#pragma once
// The islands on which sweeps stall, and the clusters of heavy bodies in large ones.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "talus/constraint/solver_state.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/clusters.hpp"
#include "talus/solver/direct/isolated_island.hpp"

namespace talus::detail {

/// An island, or a cluster of one.
struct stalled_island {
  static constexpr std::uint32_t none = overloaded_clusters::none;
  /// Contacts, or bodies, of islands that are solved in each step in which they stall. Of larger
  /// ones only long ones and the clusters of heavy bodies on light ones are, unless the island
  /// rests. A cylinder on a face has sixteen contacts.
  static constexpr std::size_t small = 64, few_bodies = 10;
  /// Operations for each contact from which a body on many points, or a few such bodies, are solved
  /// by bodies.
  static constexpr real many_points = 2.5e4;
  /// Larger islands are not solved as a whole, unless their bodies can rest on each other: sweeps
  /// work well, as in a pile.
  static constexpr std::size_t many = 1000;
  /// Bodies of a long island beside each other, at most: arches, towers and columns are long.
  static constexpr real abreast = 4;
  /// Sweeps that would remove the error of an island, of which the sweeps of a step are a small
  /// part.
  static constexpr real too_many_sweeps = 100;

  std::size_t size = 0, end = 0;  ///< number of its contacts, and their end in `members_`
  std::size_t bodies = 0;
  std::uint32_t within = none;  ///< the island of a cluster
  std::uint32_t cluster = none;
  bool overloaded = false;  ///< sweeps fail: a cluster, or a small island with one
  bool jointed = false;     ///< contains bodies with joints
  bool elsewhere = false;   ///< solved as a part of a gathered island
  bool is_long = false;     ///< long and narrow, and does not flow
  bool rests = false;       ///< a few bodies that rest on each other
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
  [[nodiscard]] bool is_small() const { return size <= small || bodies <= few_bodies; }
  [[nodiscard]] bool sweeps_do() const { return size > many && !is_cluster(); }
  /// Whether it is so long and narrow that sweeps fail, with so many contacts in a row: its
  /// solution costs less than they.
  [[nodiscard]] bool is_narrow(real in_a_row) const {
    return static_cast<real>(bodies) <= abreast * in_a_row &&
           in_a_row * in_a_row * most_mass > too_many_sweeps * least_mass;
  }
  /// A row begins and ends at contacts with what cannot move.
  [[nodiscard]] bool may_be_long() const {
    return !is_cluster() && is_narrow(static_cast<real>(bodies) + 2);
  }
  void add(real mass) {
    least_mass = std::min(least_mass, mass), most_mass = std::max(most_mass, mass);
  }
};

/// The contacts of all lists, numbered from 0, and what stalls among them.
template <class State>
class stalled_search {
  using access = contact_access<State>;
  using island = stalled_island;

 public:
  /// The contacts of each list that still change, with their changes.
  using changed = std::span<const std::span<const plain_pair<std::size_t, real>>>;

  stalled_search(std::span<const access> lists, changed changes, const State& s) : lists_(lists) {
    join_bodies(s);
    gather(changes, s);
  }
  [[nodiscard]] plain_vector<island>& islands() { return islands_; }
  [[nodiscard]] bool is_solved_here(const island& one) const {
    return !one.elsewhere && (balances_ || !one.sweeps_do());
  }
  [[nodiscard]] std::span<const std::size_t> members_of(const island& one) const {
    return {members_.data() + (one.end - one.size), one.size};
  }
  void set(std::size_t n, const vec3& impulse, State& s) const {
    const member m = place_of(n);
    lists_[m.list].set(m.index, impulse, s);
  }
  [[nodiscard]] isolated_island isolate(const island& one, const State& s) {
    plain_vector<island_contact> contacts;
    contacts.reserve(one.size);
    for (const std::size_t n : members_of(one)) {
      const member m = place_of(n);
      contacts.push_back(lists_[m.list].contact(contact_part::interior, m.index));
    }
    isolated_island alone(std::move(contacts), s, numbers_);
    if (one.is_cluster())
      for (std::size_t k = 0; k < alone.bodies.size(); ++k)
        if (clusters_.of(static_cast<std::int32_t>(alone.bodies[k])) != one.cluster)
          alone.state.bodies[k].inverse_mass = 0;  // carries the cluster
    return alone;
  }

 private:
  static constexpr std::uint32_t none = island::none;

  struct member {
    std::size_t list, index;
  };
  [[nodiscard]] bool moves(std::int32_t i) const { return mass_of(i) > 0; }

  [[nodiscard]] std::uint32_t root(const contact_ends& c) {
    return sets_.root(moves(c.a) ? c.a : c.b);
  }
  void join_bodies(const State& s) {
    masses_.resize(s.bodies.size());
    for (std::size_t i = 0; i < s.bodies.size(); ++i)
      masses_[i] = s.bodies[i].inverse_mass != 0 ? 1 / real(s.bodies[i].inverse_mass) : 0;
    for (const access& list : lists_) {
      firsts_.push_back(ends_.size());
      list.add_ends(contact_part::interior, ends_);
    }
    firsts_.push_back(ends_.size());
    sets_.reset(s.bodies.size());
    for (const auto [a, b] : ends_)
      if (b >= 0 && moves(a) && moves(b)) sets_.join(a, b);
    sets_.shorten();
  }
  void gather(changed changes, const State& s) {
    number_.assign(s.bodies.size(), 0);  // from 1, of the island of a root
    for (std::size_t k = 0; k < changes.size(); ++k)
      for (const auto& [i, change] : changes[k]) {
        auto& number = number_[root(ends_[firsts_[k] + i])];
        if (number == 0) {
          islands_.emplace_back();
          number = static_cast<std::uint32_t>(islands_.size());
        }
        island& one = islands_[number - 1];
        one.change = std::max(one.change, change);
      }
    island_of_.resize(ends_.size());
    for (std::size_t n = 0; n < ends_.size(); ++n) {
      const std::uint32_t number = island_of_[n] = number_[root(ends_[n])];
      if (number != 0) ++islands_[number - 1].size;
    }
    for (std::size_t i = 0; i < masses_.size(); ++i)
      if (const auto number = masses_[i] > 0 ? number_[sets_.root(i)] : 0; number != 0) {
        ++islands_[number - 1].bodies;
        islands_[number - 1].add(masses_[i]);
      }
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
    for (std::size_t n = 0; n < ends_.size(); ++n)
      if (const auto number = island_of_[n]; number != 0) add(islands_[number - 1], n);
    each_of_clusters([&](island& one, std::size_t n) { add(one, n); });
    numbers_.assign(s.bodies.size(), -1);
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
  /// The number of the island of a body among the islands.
  [[nodiscard]] std::uint32_t cluster_at(std::int32_t body) {
    const std::uint32_t of = clusters_.of(body);
    return of == none ? none : cluster_number_[of];
  }
  void find_clusters(changed changes) {
    if (std::none_of(islands_.begin(), islands_.end(), [](const island& one) {
          return !one.elsewhere && one.most_mass > overloaded_clusters::heavy * one.least_mass;
        }))
      return;
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
          islands_[within].overloaded |= islands_[within].is_small();
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

  /// Where a contact is.
  [[nodiscard]] member place_of(std::size_t n) const {
    std::size_t list = 0;
    while (n >= firsts_[list + 1]) ++list;
    return {list, n - firsts_[list]};
  }

  std::span<const access> lists_;
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
