#pragma once
// features<sleeping>: islands, that is bodies joined by contacts or joints (immovable ones do not
// join), that have rested for a while are left out of the steps. features/sleeping/sleep.hpp
// decides which bodies sleep or wake; this file holds the memory of an island, and spreads waking
// through it.
//
// The flag of a body is changed by its owner alone, and only right before the exchange of shadow
// copies, so that at any time all ranks that know the body agree on it. In a step a sleeping body
// is as immovable as a fixed one.
//
// The memory of the contacts of a sleeping body is frozen in `sleep.contacts`, on each rank that
// owns one of their bodies, when the first of the two is put to sleep, and restored when both are
// awake again: both ranks of a contact then continue from the same impulse.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "talus/contact/key.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/id_table.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/features/sleeping/lowest_over_joints.hpp"
#include "talus/features/sleeping/sleep_state.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Whether nothing known to this rank can move in this step.
template <class Scenario>
[[nodiscard]] bool all_rest(const held_bodies<Scenario>& s) {
  if constexpr (!state_traits<Scenario>::sleeps) return (void)s, false;
  bool rest = true;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size() && rest; ++i) rest = !b.movable.moves(i);
  });
  return rest;
}

/// The largest acceleration of a body by gravity and forces in this step.
template <class Store>
[[nodiscard]] real acceleration_bound(const step_conditions& s, const Store& store, std::size_t i) {
  if (!store.moves(i)) return 0;
  real a = s.gravity.norm();
  if constexpr (Store::forced) a += store.inverse_mass[i] * store.force[i].norm();
  return a;
}

/// Whether two bodies are within the slack of contacts, or soon will be at their present motion.
template <class Scenario, class StoreA, class StoreB>
[[nodiscard]] bool about_to_touch(const world_state<Scenario>& s, const StoreA& a, std::size_t i,
                                  const StoreB& b, std::size_t j) {
  using A = typename StoreA::shape_type;
  using B = typename StoreB::shape_type;
  bool touch = false;
  if constexpr (collidable<A, B>) {
    real size = a.shape[i].bounding_radius(), speed = (a.velocity[i] - b.velocity[j]).norm();
    if constexpr (B::finite) size = 2 * std::min(size, b.shape[j].bounding_radius());
    const real slack = contact_slack * size, ahead = steps_of_warning * s.dt;
    // If bodies are followed, a struck body must be awake before the impact: the change of motion
    // by forces and rotation within a step counts too.
    real further = 0;
    if constexpr (world_state<Scenario>::continuous) {
      further = s.dt * s.dt * (acceleration_bound(s, a, i) + acceleration_bound(s, b, j));
      if constexpr (StoreA::tensor)
        further += s.dt * a.angular_velocity[i].norm() * a.shape[i].bounding_radius();
      if constexpr (StoreB::tensor)
        further += s.dt * b.angular_velocity[j].norm() * b.shape[j].bounding_radius();
    }
    if constexpr (StoreA::tensor)
      speed += a.angular_velocity[i].norm() * a.shape[i].bounding_radius();
    if constexpr (StoreB::tensor)
      speed += b.angular_velocity[j].norm() * b.shape[j].bounding_radius();
    collide_pair(
        a.shape[i], a.pose(i), b.shape[j], b.pose(j), slack + further + ahead * speed,
        [&](const contact_geometry& g) {
          const vec3 u = a.velocity[i] + a.angular_velocity[i].cross(g.point - a.position[i]) -
                         b.velocity[j] - b.angular_velocity[j].cross(g.point - b.position[j]);
          touch = touch || g.gap + ahead * std::min(g.normal.dot(u), real(0)) <= slack + further;
        });
  }
  return touch;
}

/// The user changes a body: its island, or the island that it supports, wakes in the next step.
template <class Scenario, class Store>
void disturb(world_state<Scenario>& s, Store& store, std::size_t i) {
  if (store.inverse_mass[i] == 0) {
    store.flags[i] |= flag_disturbed;
  } else if constexpr (Store::sleeps) {
    if (store.asleep(i)) {
      store.flags[i] &= static_cast<std::uint8_t>(~flag_asleep);
      s.sleep.changed = s.sleep.spreads = true;
    }
    store.quiet[i] = 0;
  }
}

/// A body that is about to fall asleep wakes no other body: islands would keep each other awake.
template <class Scenario>
[[nodiscard]] bool wakes_others(const world_state<Scenario>& s, float quiet) {
  return quiet == 0 || quiet < static_cast<float>(s.sleep.settings.time);
}

/// Records the bodies of a close pair that must wake; true if no contact is to be made of it.
template <class Scenario, class StoreA, class StoreB>
[[nodiscard]] bool meet_sleeper(world_state<Scenario>& s, const StoreA& a, std::size_t i,
                                const StoreB& b, std::size_t j) {
  if (!a.asleep(i) && !b.asleep(j)) return false;
  if (undisturbed(a, i, b, j)) return true;
  const auto note = [&](const auto& sleeper, std::size_t k, const auto& waker, std::size_t l) {
    if constexpr (std::remove_cvref_t<decltype(waker)>::sleeps)
      if (sleeper.asleep(k) && (k < sleeper.locals || world_state<Scenario>::periodic) &&
          wakes_others(s, waker.quiet[l]) && about_to_touch(s, a, i, b, j))
        s.sleep.touched.push_back({sleeper.id[k], waker.quiet[l]});
  };
  note(a, i, b, j);
  note(b, j, a, i);
  return false;
}

/// All bodies known to a rank, in the order of their ids, for putting islands to sleep and waking
/// them.
struct known_body {
  enum state : std::uint8_t { awake, asleep, immovable, disturbed };
  system_id id = no_id;
  state is = awake;
  bool own = false;
  float quiet = 0;

  /// By id; of a body and its images, the body itself comes first.
  [[nodiscard]] bool operator<(const known_body& other) const {
    return id < other.id || (id == other.id && own && !other.own);
  }
};

template <class Scenario>
class known_bodies {
 public:
  static constexpr std::uint32_t unknown = id_table::unknown;

  explicit known_bodies(const held_bodies<Scenario>& s) {
    s.each_shape([&](const auto& b) { add(b.movable), add(b.global); });
    sort_values(all_);
    if constexpr (state_traits<Scenario>::periodic) {  // a body and its images may both be here
      const auto same = [](const known_body& x, const known_body& y) { return x.id == y.id; };
      all_.erase(std::unique(all_.begin(), all_.end(), same), all_.end());
    }
    places_ = id_table(all_, [](const known_body& k) { return k.id; });
  }
  [[nodiscard]] std::uint32_t find(system_id id) const { return places_.find(id); }
  /// Whether one of the two belongs to this rank.
  [[nodiscard]] bool own(const contact_key& k) const {
    const auto a = find(k.a), b = find(k.b);
    return (a != unknown && all_[a].own) || (b != unknown && all_[b].own);
  }
  /// Whether no contact is made of the pair.
  [[nodiscard]] bool rest(const contact_key& k) const {
    const auto rests = [&](system_id id) {
      const auto at = find(id);
      return at == unknown || all_[at].is != known_body::awake;
    };
    return rests(k.a) && rests(k.b);
  }
  [[nodiscard]] std::size_t size() const { return all_.size(); }
  [[nodiscard]] const known_body& operator[](std::size_t k) const { return all_[k]; }

 private:
  template <class Store>
  void add(const Store& store) {
    for (std::size_t i = 0; i < store.size(); ++i) {
      known_body k{.id = store.id[i], .own = i < store.locals};
      if (store.asleep(i))
        k.is = known_body::asleep;
      else if (store.inverse_mass[i] == 0)
        k.is = store.flags[i] & flag_disturbed ? known_body::disturbed : known_body::immovable;
      else if constexpr (Store::sleeps)
        k.quiet = store.quiet[i];
      all_.push_back(k);
    }
  }
  plain_vector<known_body> all_;
  id_table places_;
};

/// Whether any body may have to wake.
template <class Scenario>
[[nodiscard]] bool wakes_pend(const world_state<Scenario>& s) {
  return s.sleep.all || s.sleep.spreads || !s.sleep.touched.empty();
}

/// Whether a condition holds on any rank, if sleep must not depend on the ranks.
template <class Scenario>
[[nodiscard]] bool anywhere(world_state<Scenario>& s, bool here) {
  if constexpr (world_state<Scenario>::link_type::alone) return (void)s, here;
  const stage_clock clock(s.seconds.exchange);
  double any = here ? 1 : 0;
  s.link->reduce(reduction::max, std::span(&any, 1));
  return any != 0;
}

/// Takes the lower of the values of this rank and its neighbours for the bodies that both know.
/// Returns whether any rank has lowered one.
template <class Scenario>
[[nodiscard]] bool share_wakes(world_state<Scenario>& s, const known_bodies<Scenario>& known,
                               plain_vector<float>& wakes) {
  using code = typename world_state<Scenario>::copy_code;
  const stage_clock clock(s.seconds.exchange);
  // Calls f(neighbour, value): of the bodies with a copy there, and of the copies from there. The
  // neighbour has these two lists in reverse roles.
  const auto each = [&](bool own_first, auto&& f) {
    std::size_t k = 0;
    s.each_finite_shape([&](const auto& b) {
      const auto value = [&](std::size_t i) -> float& {
        return wakes[known.find(b.movable.id[i])];
      };
      for (const bool own : {own_first, !own_first}) {
        std::size_t copy = b.movable.locals;
        for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
          if (own)
            for (const auto i : s.neighbours[n].shadowed[k]) f(n, value(code::body(i)));
          else
            for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c) f(n, value(copy++));
        }
      }
      ++k;
    });
  };
  std::vector<neighbour_message> neighbour_messages;
  for (const auto& n : s.neighbours) neighbour_messages.push_back({.rank = n.rank});
  each(true,
       [&](std::size_t n, float& value) { byte_writer(neighbour_messages[n].out).put(value); });
  s.link->start(neighbour_messages);
  s.link->finish(neighbour_messages);
  std::vector<byte_reader> in;
  for (const neighbour_message& p : neighbour_messages) in.emplace_back(p.in);
  bool lower = false;
  each(false, [&](std::size_t n, float& value) {
    const float there = in[n].template get<float>();
    if (there < value) value = there, lower = true;
  });
  return anywhere(s, lower);
}

/// Before shadow copies are shared: wakes the bodies owned here whose island something has
/// disturbed: an approaching body, a contact partner that is awake, was disturbed or was removed,
/// or the user. `over_joints`: also the rest of islands of joints, on other ranks; these take part.
template <class Scenario>
void wake_islands(world_state<Scenario>& s, bool over_joints = false) {
  auto& sleep = s.sleep;
  const bool everywhere = s.by_colours();  // all ranks take part together
  over_joints = over_joints && world_state<Scenario>::has_joints && !sleep.asleep.empty();
  if (!everywhere && !over_joints && !wakes_pend(s)) return;
  const bool all = std::exchange(sleep.all, false);
  sleep.spreads = false;
  constexpr float never_rests = std::numeric_limits<float>::infinity();
  const known_bodies<Scenario> known(s);
  disjoint_sets islands(known.size());
  plain_vector<float> wakes(known.size(), never_rests);
  const auto wake = [&](std::uint32_t k, float quiet) { wakes[k] = std::min(wakes[k], quiet); };
  const auto meet = [&](std::uint32_t sleeper, std::uint32_t k) {
    if (k == known.unknown || known[k].is == known_body::disturbed)
      wake(sleeper, 0);
    else if (known[k].is == known_body::awake && wakes_others(s, known[k].quiet))
      wake(sleeper, known[k].quiet);
  };
  const auto connect = [&](system_id id_a, system_id id_b) {
    const auto a = known.find(id_a), b = known.find(id_b);
    const bool sleeps_a = a != known.unknown && known[a].is == known_body::asleep;
    const bool sleeps_b = b != known.unknown && known[b].is == known_body::asleep;
    if (sleeps_a && sleeps_b)
      islands.join(a, b);
    else if (sleeps_a)
      meet(a, b);
    else if (sleeps_b)
      meet(b, a);
  };
  for (const auto& c : sleep.contacts.entries()) connect(c.key.a, c.key.b);
  if constexpr (world_state<Scenario>::has_joints)
    s.joints.each_kind([&](const auto& of_kind) {
      for (const auto& r : of_kind.records)
        if (known.find(r.key.a) != known.unknown && known.find(r.key.b) != known.unknown)
          connect(r.key.a, r.key.b);
    });
  for (const auto& [id, quiet] : sleep.touched)
    if (const auto k = known.find(id); k != known.unknown) wake(k, quiet);
  sleep.touched.clear();
  const auto spread = [&] {
    for (std::uint32_t k = 0; k < known.size(); ++k) {
      const std::uint32_t root = islands.root(k);
      wakes[root] = std::min(wakes[root], wakes[k]);
    }
  };
  spread();
  if constexpr (world_state<Scenario>::has_joints)
    if (over_joints)
      take_lowest_over_joints(
          s, true,
          [&](std::size_t k, const joint_end&) {
            return islands.root(known.find(s.joints.ids().members[k].id));
          },
          wakes);
  if constexpr (world_state<Scenario>::may_use_colours &&
                !world_state<Scenario>::link_type::alone) {
    const auto give = [&] {  // to all of each island
      for (std::uint32_t k = 0; k < known.size(); ++k) wakes[k] = wakes[islands.root(k)];
    };
    if (everywhere)
      for (give(); share_wakes(s, known, wakes); give()) spread();
  }
  s.each_finite_shape([&](auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i) {
      if (!b.movable.asleep(i)) continue;
      const float quiet = all ? 0 : wakes[islands.root(known.find(b.movable.id[i]))];
      if (quiet == never_rests) continue;
      b.movable.flags[i] &= static_cast<std::uint8_t>(~flag_asleep);
      b.movable.quiet[i] = quiet;
      b.movable.unborne[i] = columns::unborne::initial;
      b.movable.drift[i].since = 0;
      sleep.changed = true;
    }
  });
}

/// After shadow copies were shared and a body known here fell asleep, woke or left: freezes and
/// restores the memory of contacts.
template <class Scenario>
void note_sleepers(world_state<Scenario>& s) {
  auto& sleep = s.sleep;
  const known_bodies<Scenario> known(s);
  plain_vector<system_id> now;
  for (std::size_t k = 0; k < known.size(); ++k)
    if (known[k].is == known_body::asleep) now.push_back(known[k].id);
  const auto before = std::exchange(sleep.asleep, std::move(now));
  const auto in = [](const plain_vector<system_id>& list, system_id id) {
    return std::binary_search(list.begin(), list.end(), id);
  };
  const auto slept = [&](const contact_key& k) { return in(before, k.a) || in(before, k.b); };
  const auto sleeps = [&](const contact_key& k) {
    return in(sleep.asleep, k.a) || in(sleep.asleep, k.b);
  };
  const auto woke = [&](const contact_key& k) {
    return (in(before, k.a) && !in(sleep.asleep, k.a)) ||
           (in(before, k.b) && !in(sleep.asleep, k.b));
  };
  using history = std::remove_cvref_t<decltype(s.history)>;
  // Only one of its two ranks has the memory of a contact with a sleeping body from steps in which
  // that slept: it ends when the body wakes.
  history awake, frozen;
  for (const auto& c : sleep.contacts.entries()) {
    if (!known.own(c.key)) continue;  // migrated
    if (woke(c.key) || !sleeps(c.key)) awake.add(c.key, c.memory);
    if (sleeps(c.key)) frozen.add(c.key, c.memory);
  }
  const auto thawed = [&, some = awake.entries().size() > 0](const contact_key& k) {
    bool any = false;
    if (some) awake.each_of_pair(k, [&](const auto&) { any = true; });
    return any;
  };
  plain_vector<typename history::entry> others;
  for (const auto& c : s.history.entries())
    if (!woke(c.key) && !thawed(c.key) && !(sleeps(c.key) && known.rest(c.key)))
      others.push_back(c);
  for (const auto& c : others) awake.add(c.key, c.memory);
  for (const auto& c : s.history.entries())
    if (sleeps(c.key) && !slept(c.key)) frozen.add(c.key, c.memory);
  s.history = std::move(awake);
  sleep.contacts = std::move(frozen);
  s.found.known = false;
  s.found.pause = 0;
  sleep.spreads = s.by_colours() || !sleep.asleep.empty();
  sleep.noted = true;
}

/// Calls f(contact) for the memory of contacts of sleeping bodies while they are left out.
template <class Scenario, class F>
void each_frozen_contact(const world_state<Scenario>& s, F&& f) {
  const known_bodies<Scenario> known(s);
  for (const auto& c : s.sleep.contacts.entries())
    if (known.rest(c.key)) f(c);
}

}  // namespace talus::detail
