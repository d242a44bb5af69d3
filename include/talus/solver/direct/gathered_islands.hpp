#pragma once
// Heavy bodies on light ones of several ranks: one rank solves the contacts around them.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/id.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/body_ties.hpp"
#include "talus/solver/direct/island_problem.hpp"
#include "talus/solver/direct/solve_bodies.hpp"

namespace talus::detail {

/// A plate on thousands of bodies of many ranks needs one solution for all its contacts: sweeps
/// would need as many iterations as there are bodies, times the ratio of the masses. The rank that
/// owns such a body (a hub: heavier than a multiple of all lighter bodies that it touches) notifies
/// the ranks that have copies of it. After the last sweep these send the owner their contacts in
/// the islands around it. The owner solves them with its own, as stalled_islands does on one rank,
/// and sends the impulses back. Of the contacts between two other ranks only those with hubs take
/// part; the others keep their impulses. If islands join several hubs, their contacts go to the
/// owner of the heaviest one in one step, and to any of them in the next: some owners may not see
/// that islands of another rank join their hub with a heavier one. In the first step, which has no
/// impulses of an earlier one, they go to either of them twice. Only ranks that hold a hub or a
/// copy of one send messages.
template <class State>
class gathered_islands {
  using access = contact_access<State>;

 public:
  /// Islands are left to the sweeps if one rank has more contacts of them, or all ranks together
  /// more than four times as many.
  static constexpr std::size_t most_contacts = 30000;
  /// A hub has this multiple of the mass of all lighter bodies that it touches, and touches at
  /// least so many of them.
  static constexpr real heavy = 5;
  static constexpr int fewest = 4;
  static constexpr std::uint64_t first_rounds = 4;  ///< in the first step

  /// Before any impulse is applied: finds the hubs among the bodies owned here.
  void find_hubs(std::span<const access> lists, State& s, int own,
                 std::span<const travelling_bodies> travelling) {
    hubs_.clear(), s.gathered.clear();
    std::fill(is_hub_.begin(), is_hub_.end(), char{0});
    ++round_;
    if (pause_ > 0) return (void)--pause_;
    plain_vector<std::uint32_t> candidates;
    each_contact(lists, contact_part::boundary, [&](const contact_ends& c, const member&) {
      const real a = inverse_mass(s, c.a), b = inverse_mass(s, c.b);
      if (heavy * std::min(a, b) < std::max(a, b))
        candidates.push_back(static_cast<std::uint32_t>(a < b ? c.a : c.b));
    });
    if (candidates.empty()) return;
    std::sort(candidates.begin(), candidates.end());
    candidates.resize(static_cast<std::size_t>(std::unique(candidates.begin(), candidates.end()) -
                                               candidates.begin()));
    note_owners(s, own, travelling);
    plain_vector<real> below(s.bodies.size(), 0);
    plain_vector<int> supports(s.bodies.size(), 0);
    for (const auto part : {contact_part::interior, contact_part::boundary})
      each_contact(lists, part, [&](const contact_ends& c, const member&) {
        if (c.b < 0 || !moves(s, c.a) || !moves(s, c.b)) return;
        const real a = 1 / inverse_mass(s, c.a), b = 1 / inverse_mass(s, c.b);
        if (a == b) return;
        const std::size_t upper = at(a > b ? c.a : c.b);
        below[upper] += std::min(a, b), ++supports[upper];
      });
    for (const std::uint32_t i : candidates)
      if (const auto body = static_cast<std::int32_t>(i);
          owner_[i] == own && supports[i] >= fewest && 1 / inverse_mass(s, body) > heavy * below[i])
        add_hub(i);
  }
  /// For sending, and for receiving of copies.
  [[nodiscard]] bool is_hub(std::uint32_t body) const {
    return body < is_hub_.size() && is_hub_[body] != 0;
  }
  void add_hub(std::uint32_t body) {
    hubs_.push_back({static_cast<std::int32_t>(body)});
    if (body >= is_hub_.size()) is_hub_.resize(body + std::size_t{1}, char{0});
    is_hub_[body] = 1;
  }

  /// After the hubs have been shared: contacts solved here belong to no stalled island.
  void mark(std::span<const access> lists, State& s) const {
    if (hubs_.empty()) return;
    for (const hub& h : hubs_) s.gathered.push_back(static_cast<std::uint32_t>(h.body));
    each_contact(lists, contact_part::boundary, [&](const contact_ends& c, const member&) {
      if (is_hub(static_cast<std::uint32_t>(c.a)) || is_hub(static_cast<std::uint32_t>(c.b)))
        s.gathered.push_back(static_cast<std::uint32_t>(c.a)),
            s.gathered.push_back(static_cast<std::uint32_t>(c.b));
    });
  }

  /// After the last sweep. `neighbour_messages` becomes one for each other rank that takes part;
  /// `exchange()` sends and receives them.
  void solve(std::span<const access> lists, State& s, int own,
             std::span<const travelling_bodies> travelling,
             std::vector<neighbour_message>& neighbour_messages,
             const std::function<void()>& exchange) {
    neighbour_messages.clear();
    if (hubs_.empty()) return;
    note_owners(s, own, travelling);
    for (const auto& other : travelling)
      if (holds_hub(other.sent) || holds_hub(other.received))
        neighbour_messages.push_back({.rank = other.rank});
    // Without impulses of an earlier step, one owner alone would leave the hubs of others to fall.
    const std::uint64_t last = round_ == 1 ? first_rounds : round_;
    for (std::uint64_t round = round_; round <= last; ++round) {
      find_parts(lists, s, own, round);
      for (neighbour_message& p : neighbour_messages) tell(lists, s, parts_[p.rank], p.out);
      exchange();
      solve_here(lists, s, parts_[own], neighbour_messages);
      exchange();
      for (neighbour_message& p : neighbour_messages) {
        byte_reader in(p.in);
        take(lists, s, parts_[p.rank], in.get_all<vec3>());
      }
    }
  }

 private:
  struct hub {
    std::int32_t body;
    int owner = -1;
    real mass = 0;
    system_id id = no_id;
    [[nodiscard]] bool before(const hub& other, std::uint64_t round) const {
      if (round % 2 == 1) return mix(value_of(id) ^ round) < mix(value_of(other.id) ^ round);
      return mass != other.mass ? mass > other.mass : id < other.id;
    }
  };
  struct member {
    std::size_t list;
    contact_part part;
    std::size_t index;
  };
  struct part {
    plain_vector<member> contacts;
    plain_vector<plain_pair<system_id, std::int32_t>> bodies;
    bool too_large = false;
  };
  /// The form of bodies in messages.
  struct reported_body {
    system_id id;
    vec3 v, w;
    real inverse_mass;
    mat3 inverse_inertia;
  };
  struct reported_contact {
    contact_key key;
    std::int32_t a_moves, b_moves, boundary, none;
    island_contact contact;
  };
  using place = std::tuple<system_id, system_id, std::uint64_t>;
  static place place_of(const contact_key& k) { return {k.a, k.b, k.feature}; }

  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  static real inverse_mass(const State& s, std::int32_t i) {
    return real(s.bodies[at(i)].inverse_mass);
  }
  static bool moves(const State& s, std::int32_t i) { return s.bodies[at(i)].inverse_mass != 0; }
  template <class F>
  static void each_contact(std::span<const access> lists, contact_part p, F&& f) {
    for (std::size_t k = 0; k < lists.size(); ++k)
      lists[k].each_ends(p, [&](const contact_ends& c, std::size_t i) { f(c, member{k, p, i}); });
  }
  void note_owners(const State& s, int own, std::span<const travelling_bodies> travelling) {
    owner_.assign(s.bodies.size(), own);
    for (const auto& other : travelling)
      for (const auto i : other.received) owner_[i] = other.rank;
  }
  [[nodiscard]] bool holds_hub(std::span<const std::uint32_t> bodies) const {
    return std::any_of(bodies.begin(), bodies.end(), [&](std::uint32_t i) { return is_hub(i); });
  }

  /// The destination of contacts and bodies of this rank: its own part, or that of another one.
  void find_parts(std::span<const access> lists, State& s, int own, std::uint64_t round) {
    parts_.clear();
    plain_vector<std::int32_t> hub_of(s.bodies.size(), -1);
    for (std::size_t k = 0; k < hubs_.size(); ++k) {
      hub& h = hubs_[k];
      h.owner = owner_[at(h.body)];
      h.mass = 1 / inverse_mass(s, h.body);
      hub_of[at(h.body)] = static_cast<std::int32_t>(k);
    }
    disjoint_sets islands(s.bodies.size());
    const auto name = [&](const contact_ends& c, const contact_key& key) {
      if (const auto h = hub_of[at(c.a)]; h >= 0) hubs_[at(h)].id = key.a;
      if (c.b >= 0)
        if (const auto h = hub_of[at(c.b)]; h >= 0) hubs_[at(h)].id = key.b;
    };
    each_contact(lists, contact_part::interior, [&](const contact_ends& c, const member& m) {
      name(c, lists[m.list].key(m.part, m.index));
      if (c.b < 0 || !moves(s, c.a) || !moves(s, c.b)) return;
      islands.join(c.a, c.b);
    });
    const auto own_end = [&](const contact_ends& c) { return owner_[at(c.a)] == own ? c.a : c.b; };
    const auto with_hub = [&](const contact_ends& c) {
      return hub_of[at(c.a)] >= 0 || hub_of[at(c.b)] >= 0;
    };
    each_contact(lists, contact_part::boundary, [&](const contact_ends& c, const member& m) {
      name(c, lists[m.list].key(m.part, m.index));
    });

    plain_vector<std::int32_t> claim(s.bodies.size(), -1);  // a hub of an island
    disjoint_sets joined_hubs(hubs_.size());                // by islands
    const auto claims = [&](std::uint32_t island, std::int32_t h) {
      if (claim[island] < 0) claim[island] = h;
      joined_hubs.join(claim[island], h, [&](std::uint32_t x, std::uint32_t y) {
        return hubs_[x].before(hubs_[y], round);
      });
    };
    for (std::size_t k = 0; k < hubs_.size(); ++k)
      if (hubs_[k].owner == own) claims(islands.root(hubs_[k].body), static_cast<std::int32_t>(k));
    each_contact(lists, contact_part::boundary, [&](const contact_ends& c, const member&) {
      for (const std::int32_t end : {c.a, c.b})
        if (hub_of[at(end)] >= 0) claims(islands.root(own_end(c)), hub_of[at(end)]);
    });

    const auto part_of = [&](std::int32_t body) -> part* {
      const auto h = claim[islands.root(body)];
      return h < 0 ? nullptr : &parts_[hubs_[joined_hubs.root(h)].owner];
    };
    each_contact(lists, contact_part::interior, [&](const contact_ends& c, const member& m) {
      part* p = part_of(moves(s, c.a) ? c.a : c.b);
      if (p == nullptr) return;
      p->contacts.push_back(m);
      const contact_key& key = lists[m.list].key(m.part, m.index);
      if (moves(s, c.a)) p->bodies.emplace_back(key.a, c.a);
      if (c.b >= 0 && moves(s, c.b)) p->bodies.emplace_back(key.b, c.b);
    });
    each_contact(lists, contact_part::boundary, [&](const contact_ends& c, const member& m) {
      if (!with_hub(c)) return;
      part* p = part_of(own_end(c));
      if (p == nullptr) return;
      p->contacts.push_back(m);
      const contact_key& key = lists[m.list].key(m.part, m.index);
      own_end(c) == c.a ? p->bodies.emplace_back(key.a, c.a) : p->bodies.emplace_back(key.b, c.b);
    });
    for (auto& [rank, p] : parts_) {
      if (p.contacts.size() > most_contacts) {
        s.islands.skip(p.contacts.size());
        p = {};
        p.too_large = true;
      }
      sort_values(p.bodies);
      p.bodies.resize(static_cast<std::size_t>(std::unique(p.bodies.begin(), p.bodies.end()) -
                                               p.bodies.begin()));
    }
    (void)parts_[own];
  }

  [[nodiscard]] reported_body body_of(const State& s, system_id id, std::int32_t body) const {
    const auto& b = s.bodies[at(body)];
    return {
        id, v_of(b), w_of(b), real(b.inverse_mass),
        at(body) >= s.first_tensor ? s.tensor(at(body)) : diagonal_matrix<real>(b.inverse_inertia)};
  }
  /// With the velocity of immovable bodies included in its target and drive.
  [[nodiscard]] reported_contact contact_of(std::span<const access> lists, const State& s,
                                            const member& m) const {
    reported_contact t{
        lists[m.list].key(m.part, m.index), 0, 0,
        m.part == contact_part::boundary,   0, lists[m.list].contact(m.part, m.index)};
    island_contact& c = t.contact;
    vec3 u{0, 0, 0};
    const auto look = [&](std::int32_t body, const vec3& arm, real sign) -> std::int32_t {
      if (body < 0) return 0;
      if (moves(s, body)) return 1;
      const auto& b = s.bodies[at(body)];
      u += sign * (v_of(b) + w_of(b).cross(arm));
      return 0;
    };
    t.a_moves = look(c.a, c.arm_a, 1), t.b_moves = look(c.b, c.arm_b, -1);
    u = c.axes * u;
    c.target_velocity -= u[0];
    c.drive = {c.drive[0] + u[1], c.drive[1] + u[2]};
    return t;
  }
  void tell(std::span<const access> lists, const State& s, const part& p, byte_buffer& to) const {
    to.clear();
    byte_writer out(to);
    out.put(static_cast<std::uint64_t>(p.too_large));
    out.put(static_cast<std::uint64_t>(p.bodies.size()));
    for (const auto& [id, body] : p.bodies) out.put(body_of(s, id, body));
    out.put(static_cast<std::uint64_t>(p.contacts.size()));
    for (const member& m : p.contacts) out.put(contact_of(lists, s, m));
  }

  /// Solves the own part together with the received parcels, and writes the answers.
  void solve_here(std::span<const access> lists, State& s, const part& own,
                  std::vector<neighbour_message>& neighbour_messages) {
    solver_state all;
    std::map<system_id, std::int32_t> number;
    const auto add_body = [&](const reported_body& b) {
      number.emplace(b.id, static_cast<std::int32_t>(all.bodies.size()));
      all.bodies.push_back({b.v, b.inverse_mass, b.w, 0});
      all.tensors.push_back(b.inverse_inertia);
    };
    plain_vector<island_contact> contacts;
    std::map<place, std::int32_t> between;  // contacts between ranks come from both
    const auto add_contact = [&](const reported_contact& t) -> std::int32_t {
      island_contact c = t.contact;
      const auto find = [&](std::int32_t moving, system_id id, std::int32_t& body) {
        body = -1;
        if (!moving) return true;
        const auto known = number.find(id);
        if (known != number.end()) body = known->second;
        return body >= 0;
      };
      if (!find(t.a_moves, t.key.a, c.a) || !find(t.b_moves, t.key.b, c.b)) return -1;
      if (t.boundary) {
        const auto [known, is_new] =
            between.emplace(place_of(t.key), static_cast<std::int32_t>(contacts.size()));
        if (!is_new) return known->second;
      }
      contacts.push_back(c);
      return static_cast<std::int32_t>(contacts.size()) - 1;
    };

    std::vector<plain_vector<reported_contact>> told(neighbour_messages.size() + 1);
    bool too_large = own.too_large;
    for (const auto& [id, body] : own.bodies) add_body(body_of(s, id, body));
    for (const member& m : own.contacts) told.back().push_back(contact_of(lists, s, m));
    for (std::size_t n = 0; n < neighbour_messages.size(); ++n) {
      byte_reader in(neighbour_messages[n].in);
      if (in.get<std::uint64_t>() != 0) too_large = true;
      for (auto count = in.get<std::uint64_t>(); count > 0; --count)
        add_body(in.get<reported_body>());
      for (auto count = in.get<std::uint64_t>(); count > 0; --count)
        told[n].push_back(in.get<reported_contact>());
    }
    std::vector<plain_vector<std::int32_t>> places(told.size());
    for (std::size_t n = told.size(); n-- > 0;)
      for (const reported_contact& t : told[n]) places[n].push_back(add_contact(t));

    contact_vector r;
    if (contacts.size() > 4 * most_contacts) s.islands.skip(contacts.size()), too_large = true;
    if (too_large) wait();
    const bool better = !too_large && !contacts.empty() && improve(contacts, all, r, s);
    const auto answer = [&](std::size_t n) {
      plain_vector<vec3> impulses;
      if (!better) return impulses;
      for (std::size_t k = 0; k < told[n].size(); ++k) {
        const std::int32_t i = places[n][k];
        impulses.push_back(i < 0 ? left_as_it_is() : vec3(contacts[at(i)].axes.transpose() * r(i)));
      }
      return impulses;
    };
    for (std::size_t n = 0; n < neighbour_messages.size(); ++n) {
      neighbour_messages[n].out.clear();
      byte_writer(neighbour_messages[n].out).put(std::span<const vec3>(answer(n)));
    }
    take(lists, s, own, answer(neighbour_messages.size()));
  }
  bool improve(const plain_vector<island_contact>& contacts, const solver_state& all,
               contact_vector& r, State& s) {
    const body_problem problem(contacts, all, r);
    double budget = s.islands.open(contacts.size());
    const island_outcome found = solve_by_bodies(problem, r, budget);
    s.islands.close(budget);
    const bool better = found.after < found.before;
    if (found.too_dear && !found.solved) s.islands.skip(contacts.size());
    if (found.solved || found.after < 0.5 * found.before) {
      if (better) s.islands.solved();
      wait_ = 0;
    } else {
      wait();
    }
    return better;
  }
  void wait() { pause_ = wait_ = std::min(2 * wait_ + 7, 255); }
  /// Stands for the impulse of a contact that took no part.
  [[nodiscard]] static vec3 left_as_it_is() {
    return vec3::Constant(std::numeric_limits<real>::quiet_NaN());
  }
  void take(std::span<const access> lists, State& s, const part& p,
            const plain_vector<vec3>& impulses) const {
    if (impulses.size() != p.contacts.size()) return;  // no better than before
    for (std::size_t k = 0; k < impulses.size(); ++k) {
      const member& m = p.contacts[k];
      if (std::isnan(impulses[k][0])) continue;
      if (m.part == contact_part::boundary)
        lists[m.list].set_at_boundary(m.index, impulses[k], s);
      else
        lists[m.list].set(m.index, impulses[k], s);
    }
  }

  std::vector<hub> hubs_;      ///< owned here, and copies
  std::vector<char> is_hub_;   ///< of each body
  std::uint64_t round_ = 0;    ///< alike on all ranks
  std::map<int, part> parts_;  ///< by the rank that solves them
  plain_vector<int> owner_;
  int pause_ = 0, wait_ = 0;  ///< steps before hubs of this rank are searched again
};

}  // namespace talus::detail
