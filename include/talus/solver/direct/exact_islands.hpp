#pragma once
// Small islands on which sweeps by colours stall, each solved as one problem, alike on any ranks.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/island_parts.hpp"
#include "talus/solver/direct/known_islands.hpp"
#include "talus/solver/direct/single_island.hpp"
#include "talus/solver/direct/travelling_records.hpp"

namespace talus::detail {

/// After the last sweep the figures of the parts of an island on several ranks (see
/// island_parts.hpp) travel to each of these ranks, and if sweeps may stall on the island, its
/// bodies and contacts. Each of the ranks then solves the whole problem, in the order of ids, to
/// the same bits. What is solved, and how, follows from the island and the last two sweeps alone,
/// so that the ranks, where domains end, and restarts change nothing.
template <class State>
class exact_islands {
  using access = contact_access<State>;
  using parts_type = island_parts<State>;
  using found = typename parts_type::found;
  using number = typename State::number;
  using island = known_islands::island;

 public:
  /// Before the sweeps; see island_parts. Returns whether any island may be solved.
  bool find(colouring& pairs, const State& s) {
    if (s.fall == vec3(0, 0, 0)) return false;
    parts_.find(pairs, s);
    return !parts_.all().empty() || !parts_.ranks().empty();
  }
  /// Before each of the last two sweeps.
  void note_impulses(std::span<const access> lists, const State& s) {
    parts_.note_impulses(lists, s);
  }

  /// After the last sweep, when own bodies have their velocities. `exchange(messages)` sends
  /// messages to ranks and receives theirs.
  template <class Exchange>
  void solve(std::span<const access> lists, State& s, Exchange&& exchange) {
    // A smaller change is irrelevant, or is round-off.
    constexpr real precision = std::is_same_v<number, real> ? 1e-9 : 1e-5;
    const real speed = s.fall.norm();
    const auto may_stall = [&](const stalled_figures& f) {
      return f.may_stall(speed, precision, s.limits);
    };
    parts_.find_changes(lists, may_stall);
    share_figures(s, exchange);
    std::map<system_id, const island*> active;   // by the name of the own part
    std::map<system_id, const island*> islands;  // by the least name
    for (const found& part : parts_.all()) {
      if (part.ranks.empty() && !may_stall(part.about.figures)) continue;
      const island& one = known_.island_of(part.about.name);
      if (!one.whole || !may_stall(one.all)) continue;
      active[part.about.name] = islands[one.names[0]] = &one;
    }
    share_problems(lists, s, active, exchange);
    std::map<system_id, single_island> solved;
    for (const auto& [first, one] : islands) {
      single_island problem;
      for (const system_id name : one->names) problem.add(problems_.all.at(name));
      if (!problem.solve(s.fall, one->all, precision, s.limits)) continue;
      solved.emplace(first, std::move(problem));
      if (active.contains(first)) s.islands.solved();  // counts on one of its ranks
    }
    for (found& part : parts_.all()) {
      const auto at = active.find(part.about.name);
      if (at == active.end()) continue;
      const auto result = solved.find(at->second->names[0]);
      if (result != solved.end()) take(part, result->second, lists, s);
    }
    // The position correction looks at the impulses of the contacts of other ranks, too.
    if (!solved.empty())
      for (const access& list : lists)
        for (std::size_t i = 0; i < list.size(contact_part::foreign); ++i)
          for (const auto& [first, one] : solved)
            if (const vec3* impulse = one.find_impulse(list.key(contact_part::foreign, i)))
              list.set(contact_part::foreign, i, *impulse);
  }

 private:
  template <class Exchange>
  void share_figures(const State& s, Exchange& exchange) {
    const plain_vector<int>& ranks = parts_.ranks();
    known_.clear(s.limits), figures_.clear();
    for (const found& part : parts_.all()) {
      known_.enter(part.about);
      if (!part.ranks.empty()) figures_.all[part.about.name] = known_.packed(part.about);
    }
    if (ranks.empty()) return;
    figures_.lines.resize(ranks.size());
    for (std::size_t n = 0; n < ranks.size(); ++n) figures_.lines[n].rank = ranks[n];
    std::vector<sorted_ids> asked(ranks.size());  // bodies of large parts
    figures_.exchange_all(
        [&](std::size_t n, auto&& f) {
          each_name(
              ranks[n], [&](system_id part) { return &known_.island_of(part); }, f);
          for (const system_id body : asked[n]) f(body);
        },
        [&](std::size_t n) { return known_.are_whole(figures_.lines[n].sent); },
        [&](system_id, const byte_buffer& bytes, std::size_t n) {
          const island_part part = known_.unpacked(bytes);
          known_.enter(part);
          for (const auto& [own, other] : part.ties)
            if (std::binary_search(parts_.large().begin(), parts_.large().end(), other)) {
              asked[n].insert(other);
              known_.enter(known_.large_part(other));
              figures_.all.emplace(other, known_.packed(known_.large_part(other)));
            }
        },
        exchange);
  }
  template <class Exchange>
  void share_problems(std::span<const access> lists, const State& s,
                      const std::map<system_id, const island*>& active, Exchange& exchange) {
    problems_.clear();
    std::set<int> ranks;
    for (found& part : parts_.all())
      if (active.contains(part.about.name)) {
        parts_.collect(part, lists);
        problems_.all[part.about.name] = problem_of(part, lists, s);
        ranks.insert(part.ranks.begin(), part.ranks.end());
      }
    for (const int rank : ranks)
      problems_.lines.push_back({.rank = rank, .open = true, .sent = {}});
    const auto each_needed = [&](std::size_t n, auto&& f) {
      each_name(
          problems_.lines[n].rank,
          [&](system_id part) {
            const auto at = active.find(part);
            return at == active.end() ? nullptr : at->second;
          },
          f);
    };
    problems_.exchange_all(
        each_needed,
        [&](std::size_t n) {
          bool complete = true;
          each_needed(n,
                      [&](system_id name) { complete &= problems_.lines[n].sent.contains(name); });
          return complete;
        },
        [](system_id, const byte_buffer&, std::size_t) {}, exchange);
  }
  /// Calls f(name) for the parts of the islands of which an own part touches bodies of a rank.
  /// `island_of(name)` returns the island of an own part, or null.
  template <class IslandOf, class F>
  void each_name(int rank, IslandOf&& island_of, F&& f) {
    std::set<const island*> done;
    for (const found& part : parts_.all()) {
      if (std::find(part.ranks.begin(), part.ranks.end(), rank) == part.ranks.end()) continue;
      const island* const one = island_of(part.about.name);
      if (one == nullptr || !done.insert(one).second) continue;
      for (const system_id name : one->names) f(name);
    }
  }
  byte_buffer problem_of(const found& part, std::span<const access> lists, const State& s) const {
    byte_buffer bytes;
    byte_writer out(bytes);
    out.put(part.bodies.size());
    for (const auto& [id, body] : part.bodies) {
      const auto i = static_cast<std::size_t>(body);
      const auto& b = s.bodies[i];
      island_body one{id, {v_of(b), real(b.inverse_mass), w_of(b), real(b.inverse_inertia)}};
      one.has_tensor = s.has_tensor(i);
      if (one.has_tensor) one.tensor = s.tensor(i);
      out.put(one);
    }
    parts_.each_member(part, [&](const auto& m) {
      keyed_contact one{lists[m.list].key(m.part, m.index), lists[m.list].contact(m.part, m.index)};
      island_contact& c = one.contact;
      if (!m.counts) return;
      vec3 u{0, 0, 0};  // an immovable body may carry others along
      const auto enter = [&](std::int32_t body, const vec3& arm, real sign) {
        if (body < 0) return false;
        const auto& b = s.bodies[static_cast<std::size_t>(body)];
        if (b.inverse_mass != 0) return true;
        u += sign * (v_of(b) + w_of(b).cross(arm));
        return false;
      };
      one.a_moves = enter(c.a, c.arm_a, 1), one.b_moves = enter(c.b, c.arm_b, -1);
      u = c.axes * u;
      c.target_velocity -= u[0];
      c.drive = {c.drive[0] + u[1], c.drive[1] + u[2]};
      out.put(one);
    });
    return bytes;
  }
  /// Takes the impulses of the contacts and the velocities of the bodies of a part.
  void take(const found& part, const single_island& solved, std::span<const access> lists,
            State& s) const {
    parts_.each_member(part, [&](const auto& m) {
      lists[m.list].set(m.part, m.index, *solved.find_impulse(lists[m.list].key(m.part, m.index)));
    });
    const auto move = [&](system_id id, std::int32_t body) {
      const solver_body& now = solved.body(id);
      auto& b = s.bodies[static_cast<std::size_t>(body)];
      b.v = in_scalar<number>(now.v), b.w = in_scalar<number>(now.w);
    };
    for (const auto& [id, body] : part.bodies) move(id, body);
    for (const auto& [id, body] : part.copies) move(id, body);
  }

  parts_type parts_;
  known_islands known_;
  travelling_records figures_, problems_;
};

}  // namespace talus::detail
