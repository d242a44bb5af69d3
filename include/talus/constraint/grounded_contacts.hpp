#pragma once
// Bodies that many contacts hold to what cannot move, as a standing cylinder or a body on narrow
// slats beside each other: all these contacts of a body are solved together.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/solver_state.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Whatever cannot move is one body for a solver. More than four contacts with nearly one normal
/// are more than bear a body: single sweeps share the load between them slowly, and what they leave
/// tilts the body. Each visit to a body here sweeps all its contacts there and back until they
/// change little.
template <class Contact>
class grounded_contacts {
 public:
  static constexpr std::uint32_t enough = 4;  ///< contacts with one normal that bear a body

  void clear() { runs_.clear(), members_.clear(), groups_.clear(); }
  /// Contacts [first, last) hold a body, which can move, to one that cannot.
  void meet(std::int32_t body, std::size_t first, std::size_t last) {
    runs_.push_back({body, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last)});
  }
  /// After all have been met: chooses the bodies that are solved here.
  void choose(const plain_vector<Contact>& contacts) {
    chain_runs();
    for (std::uint32_t k = 0; k < runs_.size(); ++k)
      if (!runs_[k].goes_on && is_held_by_many(k, contacts)) gather(k);
  }
  /// The number of these bodies, which are in the order of the last call of meet() for each.
  [[nodiscard]] std::size_t size() const { return groups_.size(); }
  [[nodiscard]] std::int32_t body(std::size_t k) const { return groups_[k].body; }
  /// Whether the contacts of the k-th call of meet() are solved here.
  [[nodiscard]] bool holds(std::size_t k) const { return runs_[k].chosen; }

  void prepare(plain_vector<Contact>& contacts, const solver_state& s) const {
    for (const std::uint32_t i : members_) {
      contacts[i].prepare(s, 1, 1);
      contacts[i].correction_impulse = 0;
    }
  }
  /// A sweep over the bodies [first, last).
  template <bool Forward>
  void sweep(std::size_t first, std::size_t last, plain_vector<Contact>& contacts,
             solver_state& s) const {
    const real small = converged * s.speed;
    each<Forward>(first, last, [&](const group& g) {
      const real change = there_and_back(g, small, contacts, s);
      for (int k = 1; k < visits && change > small; ++k)
        if (there_and_back(g, small, contacts, s) <= std::max(part_left * change, small)) break;
    });
  }
  /// Until nothing of relevance changes, because it may be the only sweep of its step; then calls
  /// note(index, change of velocity) for all contacts. The first of a body also has the change of
  /// the body's velocity in all of these visits, which its contacts in other lists do not have yet.
  template <class Note>
  void sweep_watched(plain_vector<Contact>& contacts, solver_state& s, Note& note) const {
    each<false>(0, groups_.size(), [&](const group& g) {
      const auto& b = s.bodies[static_cast<std::size_t>(g.body)];
      const vec3 v = b.v, w = b.w;
      for (int k = 0; k < most_visits; ++k)
        if (there_and_back(g, negligible * s.speed, contacts, s) <= negligible * s.speed) break;
      const Contact& one = contacts[members_[g.first]];
      const real arm = (one.a == g.body ? one.arm_a : one.arm_b).norm();
      real change = (b.v - v).norm() + arm * (b.w - w).norm();
      for (std::uint32_t k = g.first; k < g.last; ++k) {
        note(members_[k], std::max(change, solve(members_[k], contacts, s)));
        change = 0;
      }
    });
  }
  void correct(std::size_t first, std::size_t last, plain_vector<Contact>& contacts,
               solver_state& s) const {
    each<true>(first, last, [&](const group& g) {
      for (std::uint32_t k = g.first; k < g.last; ++k) {
        Contact& c = contacts[members_[k]];
        const real d = c.relax_correction(s);
        c.correct_a(s, d), c.correct_b(s, d);
      }
    });
  }
  [[nodiscard]] std::size_t bytes() const {
    return runs_.capacity() * sizeof(run) + groups_.capacity() * sizeof(group) +
           (members_.capacity() + table_.capacity()) * sizeof(std::uint32_t);
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  static constexpr int visits = 8, most_visits = 64;
  static constexpr real part_left = 0.1;           ///< of the changes of the first sweep
  static constexpr real converged = 1e-8;          ///< part of solver_state::speed
  static constexpr real negligible = 1e-9;         ///< part of solver_state::speed
  static constexpr std::uint32_t most_alike = 32;  ///< runs among which those with one normal are
  static constexpr real one_normal = 1e-6;         ///< 1 - cosine of normals that are nearly one

  struct run {
    std::int32_t body;
    std::uint32_t first, last;
    std::uint32_t before = none;  ///< the run before it of the same body
    bool goes_on = false;         ///< there is a later one
    bool chosen = false;
  };
  struct group {
    std::uint32_t first, last;  ///< of members_
    std::int32_t body;
  };

  void chain_runs() {
    if (runs_.size() == 0) return;
    const std::size_t size = std::bit_ceil(2 * runs_.size());
    table_.assign(size, none);
    for (std::uint32_t k = 0; k < runs_.size(); ++k) {
      std::size_t at = mix(static_cast<std::uint64_t>(runs_[k].body)) & (size - 1);
      while (table_[at] != none && runs_[table_[at]].body != runs_[k].body)
        at = (at + 1) & (size - 1);
      if (table_[at] != none) runs_[k].before = table_[at], runs_[table_[at]].goes_on = true;
      table_[at] = k;
    }
  }
  /// Calls f(run) for a run and those before it of the same body.
  template <class F>
  void each_before(std::uint32_t k, F&& f) {
    for (; k != none; k = runs_[k].before) f(runs_[k]);
  }
  [[nodiscard]] bool is_held_by_many(std::uint32_t last, const plain_vector<Contact>& contacts) {
    std::uint32_t all = 0;
    each_before(last, [&](const run& r) { all += r.last - r.first; });
    if (all <= enough) return false;
    const auto towards = [&](const run& r) {
      const Contact& c = contacts[r.first];
      return c.a == r.body ? c.normal : vec3(-c.normal);
    };
    for (std::uint32_t k = last; k != none; k = runs_[k].before) {
      const run& r = runs_[k];
      std::uint32_t alike = 0, looked = 0;
      for (std::uint32_t n = k; n != none && looked < most_alike; n = runs_[n].before, ++looked) {
        const run& other = runs_[n];
        if (1 - towards(r).dot(towards(other)) > one_normal) continue;
        alike += other.last - other.first;
        if (alike > enough) return true;
      }
    }
    return false;
  }
  void gather(std::uint32_t last) {
    const auto first = static_cast<std::uint32_t>(members_.size());
    each_before(last, [&](run& r) {
      r.chosen = true;
      for (std::uint32_t i = r.last; i-- > r.first;) members_.push_back(i);
    });
    std::reverse(members_.begin() + first, members_.end());
    groups_.push_back({first, static_cast<std::uint32_t>(members_.size()), runs_[last].body});
  }
  template <bool Forward, class F>
  void each(std::size_t first, std::size_t last, F&& f) const {
    for (std::size_t k = first; k < last; ++k) f(groups_[Forward ? k : first + last - 1 - k]);
  }
  /// Returns the change of velocity that the change of its impulse causes.
  static real solve(std::uint32_t i, plain_vector<Contact>& contacts, solver_state& s) {
    Contact& c = contacts[i];
    const auto d = c.relax(s);
    c.apply(s, d);
    return c.speed_of(d);
  }
  /// Returns the largest change on the way back, or on the way there if none exceeds `small`, which
  /// needs no way back.
  real there_and_back(const group& g, real small, plain_vector<Contact>& contacts,
                      solver_state& s) const {
    real most = 0;
    for (std::uint32_t k = g.first; k < g.last; ++k)
      most = std::max(most, solve(members_[k], contacts, s));
    if (most <= small) return most;
    most = 0;
    for (std::uint32_t k = g.last - 1; k-- > g.first;)
      most = std::max(most, solve(members_[k], contacts, s));
    return most;
  }

  plain_vector<run> runs_;
  plain_vector<std::uint32_t> table_, members_;
  plain_vector<group> groups_;
};

}  // namespace talus::detail
