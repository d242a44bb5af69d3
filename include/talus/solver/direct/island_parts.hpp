#pragma once
// The islands of contacts as this rank sees them: what its own bodies and their contacts form.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/core/id.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/colouring.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/groups_in_contact.hpp"
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

/// Finds the parts of this rank whose islands may be solved, and their contacts.
template <class State>
class island_parts {
  using access = contact_access<State>;

 public:
  struct member {
    std::uint32_t list, index;
    contact_part part;
    bool counts;        ///< here, and not on another rank
    std::uint32_t of;   ///< the number of its part
    std::int32_t a, b;  ///< its bodies
    real inverse_mass;  ///< the sum of both
  };
  struct found {
    island_part about;
    plain_vector<int> ranks;  ///< the owners of the bodies that own ones touch
    // After collect():
    plain_vector<plain_pair<system_id, std::int32_t>> bodies;  ///< own ones, by their ids
    plain_vector<plain_pair<system_id, std::int32_t>> copies;  ///< the bodies that these touch
  };

  /// `pairs` has the bodies that touch.
  void find(colouring& pairs, const State& s) {
    noted_ = 0;
    all_.clear(), large_.clear(), ranks_.clear();
    groups_.find(pairs, s);
    for (const auto& group : groups_.all()) {
      stalled_figures& f = all_.emplace_back().about.figures;
      f = group.figures;
      f.contacts = 0;  // those of pairs, so far
    }
    for (const std::uint32_t n : groups_.units()) {
      const contact_unit& u = pairs.unit(n);
      const std::uint32_t k = groups_.group_of(u.a);
      if (k == groups_.none) continue;
      system_id& name = all_[k].about.name;
      name = std::min(name, u.id_of_a());
      if (u.b >= 0 && u.line < 0) name = std::min(name, u.id_of_b());
    }
    for (const std::uint32_t n : groups_.ties()) {
      const contact_unit& u = pairs.unit(n);
      const int other = pairs.lines[static_cast<std::size_t>(u.line)].rank;
      ranks_.push_back(other);
      const std::uint32_t k = groups_.group_of(u.a);
      if (k == groups_.none) continue;
      all_[k].about.ties.emplace_back(u.id_of_a(), u.id_of_b());
      all_[k].ranks.push_back(other);
    }
    for (const std::uint32_t n : groups_.large_ties()) large_.push_back(pairs.unit(n).id_of_a());
    sort_unique(large_), sort_unique(ranks_);
    for (found& one : all_) sort_unique(one.about.ties), sort_unique(one.ranks);
    for (const std::uint32_t i : s.jointed)
      if (const auto k = groups_.group_of(static_cast<std::int32_t>(i)); k != groups_.none)
        all_[k].about.figures.left_out = true;
  }
  /// The ranks with bodies that own ones touch.
  [[nodiscard]] const plain_vector<int>& ranks() const { return ranks_; }
  [[nodiscard]] std::vector<found>& all() { return all_; }
  /// Own bodies of larger parts that touch bodies of other ranks, ascending.
  [[nodiscard]] const plain_vector<system_id>& large() const { return large_; }

  /// Before each of the last sweeps.
  void note_impulses(std::span<const access> lists, const State& s) {
    if (all_.empty()) return;
    if (noted_ == 0) find_members(lists, s);
    std::swap(before_, last_);
    note(lists, last_);
    ++noted_;
  }
  /// After them: the contacts of each part, and the largest changes of velocity there in the last
  /// two; infinite if an impact rebounds, or if they are unknown. `may_stall(figures)` says whether
  /// impacts matter in a part that is an island.
  template <class MayStall>
  void find_changes(std::span<const access> lists, MayStall&& may_stall) {
    if (all_.empty()) return;
    note(lists, now_);
    for (std::size_t k = 0; k < members_.size(); ++k) {
      const member& m = members_[k];
      stalled_figures& f = all_[m.of].about.figures;
      if (m.counts) ++f.contacts;
      const real square = m.inverse_mass * m.inverse_mass;
      f.change = std::max(f.change, (now_[k] - last_[k]).squaredNorm() * square);
      if (noted_ >= 2)
        f.change_before = std::max(f.change_before, (last_[k] - before_[k]).squaredNorm() * square);
    }
    bool any = false;
    for (found& one : all_) {
      stalled_figures& f = one.about.figures;
      f.change = std::sqrt(f.change);
      f.change_before = noted_ < 2 ? stalled_figures::unknown : std::sqrt(f.change_before);
      any = any || !one.ranks.empty() || may_stall(f);
    }
    if (!any) return;
    striking_.clear();
    each_list(lists, [&](const access& list, contact_part p, const auto& numbers) {
      list.add_strikes(p, numbers, striking_);
    });
    for (std::size_t k = 0; k < members_.size(); ++k)
      if (striking_[k] != 0) all_[members_[k].of].about.figures.change = stalled_figures::unknown;
  }
  /// Calls f(member) for the contacts of a part, also those that count elsewhere.
  template <class F>
  void each_member(const found& one, F&& f) const {
    const auto k = static_cast<std::size_t>(&one - all_.data());
    for (std::size_t n = first_[k]; n < first_[k + 1]; ++n) f(members_[order_[n]]);
  }
  /// Finds the bodies of a part.
  void collect(found& one, std::span<const access> lists) {
    one.bodies.clear(), one.copies.clear();
    each_member(one, [&](const member& m) {
      const contact_key& key = lists[m.list].key(m.part, m.index);
      const auto enter = [&](system_id id, std::int32_t body) {
        if (body >= 0)
          (groups_.group_of(body) == m.of ? one.bodies : one.copies).emplace_back(id, body);
      };
      enter(key.a, m.a), enter(key.b, m.b);
    });
    sort_unique(one.bodies), sort_unique(one.copies);
  }

 private:
  static constexpr contact_part own_parts[]{contact_part::interior, contact_part::boundary};

  void find_members(std::span<const access> lists, const State& s) {
    const auto inverse_mass = [&](std::int32_t i) {
      return i < 0 ? real(0) : real(s.bodies[static_cast<std::size_t>(i)].inverse_mass);
    };
    members_.clear();
    for (std::uint32_t l = 0; l < lists.size(); ++l)
      for (const contact_part p : own_parts) {
        ends_.clear();
        lists[l].add_ends(p, ends_);
        for (std::uint32_t i = 0; i < ends_.size(); ++i) {
          const auto [a, b] = ends_[i];
          const std::uint32_t k = groups_.group_of(a, b);
          if (k == groups_.none) continue;
          const real of_a = inverse_mass(a), of_b = inverse_mass(b);
          // It counts on the rank of its body a, if that moves.
          const bool counts = of_a == 0 || groups_.group_of(a) == k;
          members_.push_back(
              {l, i, p, counts, k, of_a != 0 ? a : -1, of_b != 0 ? b : -1, of_a + of_b});
        }
      }
    first_.assign(all_.size() + 2, 0);
    for (const member& m : members_) ++first_[m.of + 2];
    for (std::size_t k = 2; k < first_.size(); ++k) first_[k] += first_[k - 1];
    order_.resize(members_.size());
    for (std::uint32_t n = 0; n < members_.size(); ++n) order_[first_[members_[n].of + 1]++] = n;
  }
  /// Calls f(list, part, numbers) for the members, in their order.
  template <class F>
  void each_list(std::span<const access> lists, F&& f) {
    for (std::size_t k = 0; k < members_.size();) {
      const member& first = members_[k];
      numbers_.clear();
      for (;
           k < members_.size() && members_[k].list == first.list && members_[k].part == first.part;
           ++k)
        numbers_.push_back(members_[k].index);
      f(lists[first.list], first.part, numbers_);
    }
  }
  void note(std::span<const access> lists, plain_vector<vec3>& impulses) {
    impulses.clear();
    each_list(lists, [&](const access& list, contact_part p, const auto& numbers) {
      list.add_impulses(p, numbers, impulses);
    });
  }
  template <class Values>
  static void sort_unique(Values& values) {
    sort_values(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }

  groups_in_contact<State> groups_;
  std::vector<found> all_;
  plain_vector<system_id> large_;
  plain_vector<int> ranks_;
  plain_vector<member> members_;
  plain_vector<std::uint32_t> first_, order_;  ///< the members of each part
  plain_vector<contact_ends> ends_;
  plain_vector<std::uint32_t> numbers_;
  plain_vector<vec3> before_, last_, now_;  ///< impulses of all members
  plain_vector<char> striking_;
  int noted_ = 0;
};

}  // namespace talus::detail
