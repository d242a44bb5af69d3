#pragma once
// The islands of contacts as this rank sees them: what its own bodies and their contacts form.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "talus/core/disjoint_sets.hpp"
#include "talus/core/id.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/colouring.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/clusters.hpp"
#include "talus/solver/direct/stalled_figures.hpp"

namespace talus::detail {

/// The own bodies of a rank that contacts between own bodies connect, with the contacts of these
/// bodies. All parts that contacts over ranks connect are an island.
struct island_part {
  system_id name = no_id;  ///< the least id of its bodies
  stalled_figures figures;
  /// An own body and a body of another rank that touch each other.
  plain_vector<plain_pair<system_id, system_id>> ties;
};

/// Finds the parts of this rank whose islands may be solved.
template <class State>
class island_parts {
  using access = contact_access<State>;

 public:
  struct member {
    std::uint32_t list;
    contact_part part;
    std::uint32_t index;
    bool counts;  ///< here, and not on another rank
  };
  struct found {
    island_part about;
    plain_vector<int> ranks;  ///< the owners of the bodies that own ones touch
    // After collect():
    plain_vector<member> members;                              ///< also those that count elsewhere
    plain_vector<plain_pair<system_id, std::int32_t>> bodies;  ///< own ones, by their ids
    plain_vector<plain_pair<system_id, std::int32_t>> copies;  ///< the bodies that these touch
  };

  /// `pairs` has the bodies that touch, `owner` the rank of each body of `s`.
  void find(const colouring& pairs, const State& s, int rank, plain_vector<int>&& owner) {
    all_.clear(), large_.clear(), ranks_.clear(), noted_ = 0;
    owner_ = std::move(owner), rank_ = rank;
    join_pairs(pairs, s);
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const contact_unit& u = pairs.unit(n);
      const bool own_a = is_own(u.a, s), own_b = is_own(u.b, s);
      if (!own_a && !own_b) continue;
      group& of = groups_[sets_.root(own_a ? u.a : u.b)];
      const bool tie = u.line >= 0 && moves(u.a, s) && moves(u.b, s);
      if (tie && of.figures.contacts > stalled_figures::most_contacts)
        large_.push_back(u.id_of_a());
      if (!is_looked_at(of)) continue;
      if (of.number == 0) {
        all_.emplace_back();
        of.number = static_cast<std::uint32_t>(all_.size());
        all_.back().about.figures = of.figures;
        all_.back().about.figures.contacts = 0;
        all_.back().about.name = own_a ? u.id_of_a() : u.id_of_b();
      }
      found& one = all_[of.number - 1];
      if (own_a) one.about.name = std::min(one.about.name, u.id_of_a());
      if (own_b) one.about.name = std::min(one.about.name, u.id_of_b());
      // Another rank may own the fixed body.
      one.about.figures.left_out |= is_fixed(u.a, s) || is_fixed(u.b, s);
      if (!tie) continue;
      one.about.ties.emplace_back(u.id_of_a(), u.id_of_b());
      one.ranks.push_back(owner_[at(u.b)]);
    }
    sort_unique(large_), sort_unique(ranks_);
    for (found& one : all_) sort_unique(one.about.ties), sort_unique(one.ranks);
    for (const std::uint32_t i : s.jointed)
      if (i < groups_.size())
        if (const auto n = groups_[sets_.root(i)].number; n != 0)
          all_[n - 1].about.figures.left_out = true;
  }
  /// Finds the bodies and contacts of a part.
  void collect(found& one, std::span<const access> lists, const State& s) {
    one.members.clear(), one.bodies.clear(), one.copies.clear();
    plain_vector<contact_ends> ends;
    for (std::uint32_t k = 0; k < lists.size(); ++k)
      for (const contact_part p : {contact_part::interior, contact_part::boundary}) {
        ends.clear();
        lists[k].add_ends(p, ends);
        for (std::uint32_t i = 0; i < ends.size(); ++i) {
          const contact_ends& c = ends[i];
          const bool own_a = is_own(c.a, s), own_b = is_own(c.b, s);
          if ((!own_a && !own_b) || &one != &all_[groups_[root_of(c, s)].number - 1]) continue;
          one.members.push_back({k, p, i, counts(c, s)});
          const contact_key& key = lists[k].key(p, i);
          if (moves(c.a, s)) (own_a ? one.bodies : one.copies).emplace_back(key.a, c.a);
          if (moves(c.b, s)) (own_b ? one.bodies : one.copies).emplace_back(key.b, c.b);
        }
      }
    sort_unique(one.bodies), sort_unique(one.copies);
  }
  /// The ranks with bodies that own ones touch.
  [[nodiscard]] const plain_vector<int>& ranks() const { return ranks_; }
  [[nodiscard]] std::vector<found>& all() { return all_; }
  /// Own bodies of larger parts that touch bodies of other ranks, ascending.
  [[nodiscard]] const plain_vector<system_id>& large() const { return large_; }

  /// Before each of the last sweeps.
  void note_impulses(std::span<const access> lists) {
    if (all_.empty()) return;
    std::swap(before_, last_);
    note(lists, last_);
    ++noted_;
  }
  /// After them: the contacts of each part, and the largest changes of velocity there in the last
  /// two; infinite if an impact rebounds, or if they are unknown.
  void find_changes(std::span<const access> lists, const State& s) {
    if (all_.empty()) return;
    note(lists, now_);
    for (found& one : all_)
      one.about.figures.change_before = noted_ < 2 ? stalled_figures::unknown : 0;
    plain_vector<contact_ends> ends;
    std::size_t n = 0;
    for (const access& list : lists)
      for (const contact_part p : {contact_part::interior, contact_part::boundary}) {
        ends.clear();
        list.add_ends(p, ends);
        for (const contact_ends& c : ends) {
          const std::size_t k = n++;
          if (!is_own(c.a, s) && !is_own(c.b, s)) continue;
          const std::uint32_t number = groups_[root_of(c, s)].number;
          if (number == 0) continue;
          stalled_figures& f = all_[number - 1].about.figures;
          if (counts(c, s)) ++f.contacts;
          if (striking_[k] != 0) f.change = stalled_figures::unknown;
          const real both = inverse_mass(c.a, s) + inverse_mass(c.b, s);
          f.change = std::max(f.change, (now_[k] - last_[k]).norm() * both);
          if (noted_ >= 2)
            f.change_before = std::max(f.change_before, (last_[k] - before_[k]).norm() * both);
        }
      }
  }

 private:
  [[nodiscard]] static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] static real inverse_mass(std::int32_t i, const State& s) {
    return i < 0 ? 0 : real(s.bodies[at(i)].inverse_mass);
  }
  [[nodiscard]] static bool moves(std::int32_t i, const State& s) {
    return i >= 0 && s.bodies[at(i)].inverse_mass != 0;
  }
  [[nodiscard]] static bool is_fixed(std::int32_t i, const State& s) {
    return i >= 0 && at(i) < s.first_global && s.bodies[at(i)].inverse_mass == 0;
  }
  [[nodiscard]] bool is_own(std::int32_t i, const State& s) const {
    return moves(i, s) && owner_[at(i)] == rank_;
  }
  [[nodiscard]] std::uint32_t root_of(const contact_ends& c, const State& s) const {
    return sets_.root(is_own(c.a, s) ? c.a : c.b);
  }
  /// Whether a contact of own bodies counts here: on the rank of its body a, if that moves.
  [[nodiscard]] bool counts(const contact_ends& c, const State& s) const {
    return !moves(c.a, s) || owner_[at(c.a)] == rank_;
  }

  /// Own bodies that contacts between own bodies connect, at their root.
  struct group {
    std::uint32_t number = 0;  ///< of the part, from 1
    bool tied = false;
    stalled_figures figures;  ///< with pairs in place of contacts
  };
  [[nodiscard]] static bool is_looked_at(const group& g) {
    if (g.figures.contacts > stalled_figures::most_contacts) return false;
    if (g.tied || g.figures.overloaded) return true;
    return g.figures.contacts <= stalled_figures::many && g.figures.may_be_narrow();
  }

  void join_pairs(const colouring& pairs, const State& s) {
    sets_.reset(s.bodies.size());
    groups_.assign(s.bodies.size(), {});
    bool unequal = false;
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const contact_unit& u = pairs.unit(n);
      if (!moves(u.a, s) || !moves(u.b, s)) continue;
      if (u.line < 0)
        sets_.join(u.a, u.b);
      else
        ranks_.push_back(owner_[at(u.b)]);
      const real a = inverse_mass(u.a, s), b = inverse_mass(u.b, s);
      unequal |= 4 * std::min(a, b) < std::max(a, b);
    }
    sets_.shorten();
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const contact_unit& u = pairs.unit(n);
      const bool own_a = is_own(u.a, s);
      if (!own_a && !is_own(u.b, s)) continue;
      group& of = groups_[sets_.root(own_a ? u.a : u.b)];
      ++of.figures.contacts;
      of.tied |= u.line >= 0 && moves(u.a, s) && moves(u.b, s);
    }
    for (std::uint32_t i = 0; i < groups_.size(); ++i)
      if (is_own(static_cast<std::int32_t>(i), s)) {
        group& of = groups_[sets_.root(i)];
        ++of.figures.bodies;
        of.figures.add_mass(1 / real(s.bodies[i].inverse_mass));
      }
    find_rows(pairs, s);
    if (unequal) find_overloaded(pairs, s);
  }
  /// Bodies in a row between any two of a group: at most twice those from one to the farthest.
  void find_rows(const colouring& pairs, const State& s) {
    const auto each = [&](auto&& f) {
      for (std::size_t n = 0; n < pairs.size(); ++n) {
        const contact_unit& u = pairs.unit(n);
        if (u.line >= 0 || !moves(u.a, s) || !moves(u.b, s)) continue;
        if (groups_[sets_.root(u.a)].figures.contacts <= stalled_figures::most_contacts)
          f(at(u.a), u.b), f(at(u.b), u.a);
      }
    };
    first_.assign(s.bodies.size() + 2, 0);
    each([&](std::size_t body, std::int32_t) { ++first_[body + 2]; });
    for (std::size_t k = 2; k < first_.size(); ++k) first_[k] += first_[k - 1];
    touching_.resize(first_.back());
    each([&](std::size_t body, std::int32_t other) { touching_[first_[body + 1]++] = other; });
    met_.assign(s.bodies.size(), 0);
    const auto farthest = [&](std::int32_t from, std::uint32_t& levels) {
      queue_.assign(1, from);
      const char mark = ++met_[at(from)];
      levels = 0;
      for (std::size_t k = 0, end = 1; k < queue_.size(); ++k) {
        if (k == end) end = queue_.size(), ++levels;
        const std::size_t body = at(queue_[k]);
        for (std::size_t e = first_[body]; e < first_[body + 1]; ++e)
          if (met_[at(touching_[e])] != mark)
            met_[at(touching_[e])] = mark, queue_.push_back(touching_[e]);
      }
      return queue_.back();
    };
    for (std::size_t i = 0; i < met_.size(); ++i) {
      group& of = groups_[sets_.root(i)];
      if (of.figures.contacts == 0 || of.figures.in_a_row != 0 ||
          !is_own(static_cast<std::int32_t>(i), s))
        continue;
      std::uint32_t once = 0, again = 0;
      const std::int32_t end = farthest(static_cast<std::int32_t>(i), once);
      if (once > 1) (void)farthest(end, again), once = std::min(once, again);
      of.figures.in_a_row = 2 * once + 1;
    }
  }
  /// Clusters of heavy bodies on light ones. The owner of a heavy body sees all that it touches.
  void find_overloaded(const colouring& pairs, const State& s) {
    plain_vector<contact_ends> ends;
    for (std::size_t n = 0; n < pairs.size(); ++n) {
      const contact_unit& u = pairs.unit(n);
      if (!moves(u.a, s) || !moves(u.b, s)) continue;
      const std::uint32_t root = sets_.root(is_own(u.a, s) ? u.a : u.b);
      if (groups_[root].figures.contacts <= stalled_figures::most_contacts)
        ends.push_back({u.a, u.b});
    }
    plain_vector<real> masses(s.bodies.size());
    for (std::size_t i = 0; i < masses.size(); ++i)
      masses[i] = s.bodies[i].inverse_mass != 0 ? 1 / real(s.bodies[i].inverse_mass) : 0;
    clusters_.find_possible(ends, masses, [&](std::uint32_t i) { return owner_[i] != rank_; });
    for (const contact_ends& c : ends)
      for (const std::int32_t body : {c.a, c.b})
        if (owner_[at(body)] == rank_ && clusters_.of(body) != overloaded_clusters::none)
          groups_[sets_.root(body)].figures.overloaded = true;
  }
  /// The impulses of all contacts, and whether they strike.
  void note(std::span<const access> lists, plain_vector<vec3>& impulses) {
    impulses.clear(), striking_.clear();
    for (const access& list : lists)
      for (const contact_part p : {contact_part::interior, contact_part::boundary})
        list.add_impulses(p, impulses, striking_);
  }
  template <class Values>
  static void sort_unique(Values& values) {
    sort_values(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }

  plain_vector<std::uint32_t> first_;  ///< of each body, in touching_
  plain_vector<std::int32_t> touching_, queue_;
  plain_vector<char> met_;
  plain_vector<int> owner_;  ///< of each body
  int rank_ = 0;
  mutable disjoint_sets sets_;
  plain_vector<group> groups_;  ///< of the roots
  overloaded_clusters clusters_;
  std::vector<found> all_;
  plain_vector<system_id> large_;
  plain_vector<int> ranks_;
  plain_vector<vec3> before_, last_, now_;  ///< impulses of all contacts
  plain_vector<char> striking_;
  int noted_ = 0;
};

}  // namespace talus::detail
