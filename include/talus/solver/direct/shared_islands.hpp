#pragma once
// Small groups of contacts across ranks, solved as one problem by each of these ranks, alike.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/band_system.hpp"
#include "talus/solver/direct/body_problem.hpp"
#include "talus/solver/direct/body_ties.hpp"
#include "talus/solver/direct/island_problem.hpp"
#include "talus/solver/direct/island_solver.hpp"
#include "talus/solver/direct/solve_bodies.hpp"
#include "talus/solver/direct/stalled_search.hpp"

namespace talus::detail {

/// If a stack stands on the corner of several domains, each of these ranks holds copies of all its
/// bodies, computes all its contacts, and starts from the same velocities. So each solves the whole
/// island by itself, to the same bits. It only needs to be sure that the others do the same: that
/// is known if every body has as many contacts here as its owner counts, and if every owner holds
/// every body. Fixed bodies count too: the holders of a body are those that also hold the fixed
/// bodies that it touches. Islands that do not satisfy this are left to the iterations. Few bodies
/// at rest on many points are solved by bodies, others by contacts, within a fixed cost.
template <class State>
class shared_islands {
  using access = contact_access<State>;
  using number = typename State::number;

 public:
  static constexpr std::size_t most_boundary_contacts = 400;
  static constexpr std::size_t most_contacts = 400;
  static constexpr real most_operations = 2e8;  ///< for the solution of an island
  /// Islands are left to the sweeps if points move by less than this multiple of the gain of
  /// velocity by gravity in a step.
  static constexpr real balanced = 1e-9;

  /// Whether contacts between copies of bodies of other ranks are needed: large numbers of boundary
  /// contacts, as of a pile, do not form small islands.
  [[nodiscard]] bool wanted() const { return wanted_; }

  /// Before any impulse is applied: stores the velocities, and counts the contacts of each body.
  /// `own` is this rank, `sent` and `received` hold, for each other rank, the bodies with copies
  /// there and the copies here of its bodies; `fixed` the fixed bodies with copies.
  void look(std::span<const access> lists, const State& s, int own,
            std::span<const travelling_bodies> travelling, std::span<const fixed_body_ties> fixed,
            bool shares = true) {
    std::size_t at_boundary = 0;
    for (const access& list : lists) at_boundary += list.size(contact_part::boundary);
    takes_part_ = shares && wanted_ && at_boundary > 0 && at_boundary <= most_boundary_contacts;
    wanted_ = at_boundary <= most_boundary_contacts;
    ties_.assign(s.bodies.size(), {});  // sent if this rank takes no part
    if (!takes_part_) return;
    free_ = s.bodies;
    for (body_ties& t : ties_) t.owner = own;
    for (const travelling_bodies& other : travelling) {
      for (const auto i : other.sent) ties_[i].holders.add(other.rank);
      for (const auto i : other.received) ties_[i].owner = other.rank;
    }
    each_contact(lists, [&](const contact_ends& c, member) {
      ++ties_[static_cast<std::size_t>(c.a)].contacts;
      if (c.b >= 0) ++ties_[static_cast<std::size_t>(c.b)].contacts;
    });
    for (body_ties& t : ties_)
      if (t.owner == own) t.of_owner = static_cast<std::int32_t>(t.contacts);
    // Where a fixed body is not known, its contacts are not known either.
    for (const fixed_body_ties& t : fixed) {
      ties_[t.body].holders = t.holders;
      ties_[t.body].owner = t.owner;
    }
    each_contact(lists, [&](const contact_ends& c, member) {
      if (!touches_fixed(c, s)) return;
      body_ties& t = ties_[static_cast<std::size_t>(moves(s, c.a) ? c.a : c.b)];
      if (t.owner != own) return;
      const body_ties& on = ties_[static_cast<std::size_t>(moves(s, c.a) ? c.b : c.a)];
      t.holders.keep(on.holders, on.owner);
    });
  }
  /// The ties of a body, for sending and receiving. Other ranks see no ties of a solver that never
  /// searches.
  [[nodiscard]] body_ties& ties(std::size_t body) {
    if (ties_.size() <= body) ties_.resize(body + 1);
    return ties_[body];
  }

  /// After the ties of all bodies have been shared: solves the islands that this rank shares with
  /// others. `s` then holds their velocities, and the lists their impulses.
  void solve(std::span<const access> lists, State& s) {
    if (!std::exchange(takes_part_, false)) return;
    join_bodies(lists, s);
    std::map<std::uint32_t, island> islands;
    each_contact(lists, [&](const contact_ends& c, member m) {
      if (m.part == contact_part::boundary) islands[root(s, c)];
    });
    each_contact(lists, [&](const contact_ends& c, member m) {
      const auto at = islands.find(root(s, c));
      if (at == islands.end()) return;
      island& one = at->second;
      if (one.contacts.size() > most_contacts) return;
      const contact_key& key = lists[m.list].key(m.part, m.index);
      one.contacts.push_back({key, m});
      add_body(one, s, c.a, key.a);
      if (c.b >= 0) add_body(one, s, c.b, key.b);
      one.on_fixed = one.on_fixed || touches_fixed(c, s);
    });
    for (auto& [number, one] : islands)
      if (one.contacts.size() <= most_contacts && known_alike(one) &&
          (!one.on_fixed || one.bodies.size() <= stalled_island::few_bodies))
        solve_one(one, lists, s);
  }

 private:
  struct member {
    std::size_t list;
    contact_part part;
    std::size_t index;
  };
  struct island {
    plain_vector<plain_pair<contact_key, member>> contacts;
    plain_vector<plain_pair<system_id, std::int32_t>> bodies;
    bool on_fixed = false;  ///< touches fixed bodies of ranks: is solved if few bodies rest
  };

  template <class F>
  static void each_contact(std::span<const access> lists, F&& f) {
    for (std::size_t k = 0; k < lists.size(); ++k)
      for (const auto p : {contact_part::interior, contact_part::boundary, contact_part::foreign})
        lists[k].each_ends(p, [&](const contact_ends& c, std::size_t i) { f(c, member{k, p, i}); });
  }
  static bool moves(const State& s, std::int32_t body) {
    return s.bodies[static_cast<std::size_t>(body)].inverse_mass != 0;
  }
  /// Whether one of the bodies is not global and cannot move.
  static bool touches_fixed(const contact_ends& c, const State& s) {
    return c.b >= 0 && static_cast<std::size_t>(c.b) < s.first_global &&
           moves(s, c.a) != moves(s, c.b);
  }
  std::uint32_t root(const State& s, const contact_ends& c) {
    return sets_.root(moves(s, c.a) ? c.a : c.b);
  }
  void join_bodies(std::span<const access> lists, const State& s) {
    sets_.reset(s.bodies.size());
    each_contact(lists, [&](const contact_ends& c, member) {
      if (c.b < 0 || !moves(s, c.a) || !moves(s, c.b)) return;
      sets_.join(c.a, c.b);
    });
  }
  static void add_body(island& one, const State& s, std::int32_t body, system_id id) {
    if (moves(s, body)) one.bodies.emplace_back(id, body);
  }

  /// Whether all ranks that own bodies of the island have the same view of it; sorts it by ids.
  bool known_alike(island& one) const {
    sort_values(one.bodies);
    one.bodies.erase(std::unique(one.bodies.begin(), one.bodies.end()), one.bodies.end());
    plain_vector<std::int32_t> owners;
    for (const auto& [id, body] : one.bodies) {
      const body_ties& t = ties_[static_cast<std::size_t>(body)];
      if (t.of_owner != static_cast<std::int32_t>(t.contacts)) return false;
      if (std::find(owners.begin(), owners.end(), t.owner) == owners.end())
        owners.push_back(t.owner);
    }
    for (const auto& [id, body] : one.bodies)
      for (const std::int32_t rank : owners) {
        const body_ties& t = ties_[static_cast<std::size_t>(body)];
        if (t.owner != rank && !t.holders.has(rank)) return false;
      }
    sort_values(one.contacts, [](const auto& x, const auto& y) {
      const auto &a = x.first, &b = y.first;
      return std::tuple(a.a, a.b, a.feature) < std::tuple(b.a, b.b, b.feature);
    });
    return true;
  }

  /// Whether the impulses of the last step, which the velocities contain, balance the island: no
  /// point of contact moves.
  static bool is_balanced(const island& one, std::span<const access> lists, const State& s) {
    const real least = balanced * s.fall.norm();
    const auto at_point = [&](std::int32_t body, const vec3& arm) -> vec3 {
      if (body < 0) return {0, 0, 0};
      const auto& b = s.bodies[static_cast<std::size_t>(body)];
      return v_of(b) + w_of(b).cross(arm);
    };
    for (const auto& [key, m] : one.contacts) {
      const island_contact c = lists[m.list].contact(m.part, m.index);
      const vec3 u = c.axes * (at_point(c.a, c.arm_a) - at_point(c.b, c.arm_b)) +
                     vec3(0, c.drive[0], c.drive[1]);
      if (!(u.squaredNorm() < least * least)) return false;
    }
    return true;
  }
  /// Everything in the order of ids, so that each rank computes the same bits.
  void solve_one(island& one, std::span<const access> lists, State& s) const {
    if (is_balanced(one, lists, s)) return;
    std::stable_partition(one.bodies.begin(), one.bodies.end(), [&](const auto& b) {
      return static_cast<std::size_t>(b.second) < s.first_tensor;
    });
    solver_state own;
    std::map<std::int32_t, std::int32_t> place;
    for (const auto& [id, body] : one.bodies) {
      const auto i = static_cast<std::size_t>(body);
      place[body] = static_cast<std::int32_t>(own.bodies.size());
      const auto& free = free_[i];
      own.bodies.push_back(
          {v_of(free), real(free.inverse_mass), w_of(free), real(free.inverse_inertia)});
      if (i < s.first_tensor)
        ++own.first_tensor;
      else
        own.tensors.push_back(s.tensor(i));
    }
    const auto place_of = [&](std::int32_t body) {
      const auto at = place.find(body);
      return at == place.end() ? -1 : at->second;
    };
    plain_vector<island_contact> contacts;
    for (const auto& [key, m] : one.contacts) {
      island_contact c = lists[m.list].contact(m.part, m.index);
      // An immovable body may still carry others along.
      vec3 u{0, 0, 0};
      const auto enter = [&](std::int32_t& body, const vec3& arm, real sign) {
        if (body < 0) return;
        const std::int32_t there = place_of(body);
        if (there < 0) {
          const auto& b = s.bodies[static_cast<std::size_t>(body)];
          u += sign * (v_of(b) + w_of(b).cross(arm));
        }
        body = there;
      };
      enter(c.a, c.arm_a, 1);
      enter(c.b, c.arm_b, -1);
      u = c.axes * u;
      c.target_velocity -= u[0];
      c.drive = {c.drive[0] + u[1], c.drive[1] + u[2]};
      c.impulse = {0, 0, 0};
      contacts.push_back(c);
    }
    plain_vector<vec3> impulses;
    const bool rests = is_few_at_rest(contacts, own, s.fall);
    if (one.on_fixed && !rests) return;
    if (!find_impulses(contacts, own, rests, impulses)) return;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const island_contact& c = contacts[k];
      apply_impulse(own, c.a, c.arm_a, impulses[k]);
      apply_impulse(own, c.b, c.arm_b, -impulses[k]);
      const member& m = one.contacts[k].second;
      lists[m.list].set(m.part, m.index, impulses[k]);
    }
    for (const auto& [body, at] : place) {
      auto& b = s.bodies[static_cast<std::size_t>(body)];
      b.v = in_scalar<number>(own.bodies[static_cast<std::size_t>(at)].v);
      b.w = in_scalar<number>(own.bodies[static_cast<std::size_t>(at)].w);
    }
  }
  /// From zero impulses and with a fixed number of operations, alike on all ranks.
  static bool find_impulses(const plain_vector<island_contact>& contacts, const solver_state& own,
                            bool rests, plain_vector<vec3>& impulses) {
    const contact_order order(contacts, own);
    const real cost = band_system::cost(contacts.size(), order.half_bandwidth());
    contact_vector r;
    if (rests && cost > stalled_island::many_points * static_cast<real>(contacts.size())) {
      const body_problem problem(contacts, own, r);
      if (solve_by_bodies_anew(problem, r, most_operations)) {
        for (std::size_t k = 0; k < contacts.size(); ++k)
          impulses.push_back(contacts[k].axes.transpose() * r(static_cast<int>(k)));
        return true;
      }
    }
    if (cost > most_operations / 10) return false;
    plain_vector<island_contact> chain;
    for (const auto i : order.order()) chain.push_back(contacts[i]);
    const assembled_problem problem = assemble_island(chain, own, r);
    if (!solve_island_anew(problem, r,
                           static_cast<int>(std::min<real>(60, most_operations / cost))))
      return false;
    impulses.resize(contacts.size());
    for (std::size_t k = 0; k < chain.size(); ++k)
      impulses[order.order()[k]] = chain[k].axes.transpose() * r(static_cast<int>(k));
    return true;
  }
  /// Whether a few bodies with faces on each other rest: most of their points did not move before
  /// the step faster than gravity moves them in it.
  static bool is_few_at_rest(const plain_vector<island_contact>& contacts, const solver_state& own,
                             const vec3& fall) {
    if (own.bodies.size() > stalled_island::few_bodies || contacts.size() < 3 * own.bodies.size())
      return false;
    const auto at_point = [&](std::int32_t body, const vec3& arm) -> vec3 {
      if (body < 0) return {0, 0, 0};
      const solver_body& b = own.bodies[static_cast<std::size_t>(body)];
      return b.v - fall + b.w.cross(arm);
    };
    std::size_t fast = 0;
    for (const island_contact& c : contacts) {
      const vec3 v = at_point(c.a, c.arm_a) - at_point(c.b, c.arm_b);
      if (v.squaredNorm() > fall.squaredNorm()) ++fast;
    }
    return fast <= contacts.size() / 8;
  }
  static void apply_impulse(solver_state& s, std::int32_t body, const vec3& arm,
                            const vec3& impulse) {
    if (body < 0) return;
    const auto i = static_cast<std::size_t>(body);
    s.bodies[i].v += s.bodies[i].inverse_mass * impulse;
    if (i < s.first_tensor)
      s.bodies[i].w += s.bodies[i].inverse_inertia * arm.cross(impulse);
    else
      s.bodies[i].w += s.tensor(i) * arm.cross(impulse);
  }
  bool wanted_ = true, takes_part_ = false;
  plain_vector<body_ties> ties_;
  plain_vector<solver_body_of<number>> free_;
  disjoint_sets sets_;
};

}  // namespace talus::detail
