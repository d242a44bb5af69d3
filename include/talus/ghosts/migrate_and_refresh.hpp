#pragma once
// Last stage of a step: bodies whose centre has left migrate to their new owner, and shadow copies
// are refreshed on every rank whose bodies they may touch.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "talus/core/id_table.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/ghosts/closed_faces.hpp"
#include "talus/ghosts/conservation.hpp"
#include "talus/ghosts/flights.hpp"
#include "talus/ghosts/migrating_joints.hpp"
#include "talus/ghosts/released.hpp"
#include "talus/ghosts/shadow_copies.hpp"
#include "talus/ghosts/stages.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Applies the connections made or removed since the last migration. Removes the copies of bodies
/// of ranks that are no longer connected, and sends the other copies in full.
template <class Scenario>
void match_connections(population<Scenario>& s) {
  const auto connections = s.own.connections();
  if (std::equal(connections.begin(), connections.end(), s.neighbours.begin(), s.neighbours.end(),
                 [](const auto& c, const auto& n) { return c.rank == n.rank; }))
    return;
  auto before = std::exchange(s.neighbours, {});
  s.neighbour_messages.clear();
  for (const auto& c : connections) {
    const auto old =
        std::find_if(before.begin(), before.end(), [&](const auto& n) { return n.rank == c.rank; });
    auto& now = s.neighbours.emplace_back();
    if (old != before.end()) now = std::move(*old);
    now.rank = c.rank;
    s.neighbour_messages.push_back({.rank = c.rank});
  }
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    const auto copies = b.movable.take_shadows();
    if constexpr (state_traits<Scenario>::periodic) {
      // Connections change on all ranks together there, with all copies.
      for (auto& n : s.neighbours) n.copies = {};
      return s.copies.of[k++].clear();
    }
    std::size_t first = 0;
    for (const auto& n : before) {
      const std::size_t last = first + n.copies[k];
      if (s.own.find(n.rank) != nullptr) b.movable.append_from(copies, first, last);
      first = last;
    }
    ++k;
  });
  s.choice.reach.clear();
  s.changed = true;
}

struct way {
  std::size_t connection;  ///< index of the first one
  bool ends_there;
};

/// The rank to send to for the owner of `p`: the owner itself, or a neighbour nearer to it.
template <class Scenario>
[[nodiscard]] way way_to(const rank_state<Scenario>& s, const vec3& p) {
  const auto connections = s.own.connections();
  const int owner = s.own.owner(p);
  std::size_t best = 0;
  for (std::size_t n = 0; n < connections.size(); ++n) {
    if (connections[n].rank == owner) return {n, true};
    if (connections[best].rank == s.own.rank() ||
        connections[n].distance(p) < connections[best].distance(p))
      best = n;
  }
  return {best, false};
}

template <class Scenario>
[[noreturn]] void fail_lost(const world_state<Scenario>& s, system_id id, const vec3& p) {
  fail<std::runtime_error>(
      "body {} is lost at {} in step {}: rank {} owned it, and no rank it is connected to covers "
      "that place; {}",
      id, text(p), s.steps, s.link->rank(),
      finite(p) ? "connect the ranks so that all space is covered"
                : "its motion is no longer finite: a smaller dt, or look for overlapping bodies at "
                  "the start");
}

/// The movable bodies of each neighbour that have copies here: it stores their contacts with bodies
/// of this rank, too.
class bodies_elsewhere {
 public:
  explicit bodies_elsewhere(std::size_t neighbours) : ids_(neighbours) {}
  void add(std::size_t neighbour, system_id id) { ids_[neighbour].push_back(id); }
  void sort() {
    for (auto& each : ids_) sort_values(each);
  }
  [[nodiscard]] bool owns(std::size_t neighbour, system_id id) const {
    return std::binary_search(ids_[neighbour].begin(), ids_[neighbour].end(), id);
  }

 private:
  std::vector<plain_vector<system_id>> ids_;
};

template <class Scenario>
[[nodiscard]] bodies_elsewhere movable_copies(const population<Scenario>& s) {
  bodies_elsewhere all(s.neighbours.size());
  // The memory of a contact that a feature has set aside may be on one rank only.
  if constexpr (has_more_histories<Scenario>) return all;
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    std::size_t i = b.movable.locals;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n)
      for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c, ++i)
        if (b.movable.moves(i)) all.add(n, b.movable.id[i]);
    ++k;
  });
  all.sort();
  return all;
}

/// Sends bodies whose centre has left to their new owner, with the memory of their contacts.
/// Returns the number of bodies that this rank still forwards (only if the path to their owner is
/// longer than one connection). No body moves that far in a step (`after_step`).
template <class Scenario>
std::size_t migrate(world_state<Scenario>& s, bool after_step) {
  require_all_here(s);
  update_ranges(s);
  plain_vector<plain_pair<system_id, std::size_t>> leaving;
  for (std::size_t n = 0; n < s.neighbour_messages.size(); ++n) open_message(s, n);
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    plain_vector<std::size_t> gone;
    std::vector<plain_vector<plain_pair<std::size_t, bool>>> to(s.neighbour_messages.size());
    for (std::size_t i = 0; i < store.locals; ++i) {
      const vec3& p = store.position[i];
      if (!finite(p)) fail_lost(s, store.id[i], p);
      if (s.own.contains(p)) continue;
      if constexpr (world_state<Scenario>::periodic) {
        if (!s.own.box().contains(p)) store.position[i] = s.own.box().wrapped(p);
        if (s.own.contains(p)) continue;
      }
      if (s.neighbour_messages.empty()) fail_lost(s, store.id[i], p);
      const auto [n, ends_there] = way_to(s, p);
      if (!ends_there && after_step) refuse_long_flight(s, store, i);
      to[n].emplace_back(i, ends_there);
      gone.push_back(i);
      leaving.emplace_back(store.id[i], n);
      if constexpr (world_state<Scenario>::law::soft)
        s.neighbours[n].reach = std::max(s.neighbours[n].reach, shadow_reach(s, store, i));
    }
    for (std::size_t n = 0; n < to.size(); ++n) {
      byte_writer out(s.neighbour_messages[n].out, s.neighbours[n].shared());
      out.put(static_cast<std::uint64_t>(to[n].size()));
      for (const auto& [i, ends_there] : to[n]) {
        s.neighbours[n].channel.given.add(store.id[i]);
        s.owned.remove(store.id[i]);
        out.put(ends_there);
        store.pack(i, out);
      }
    }
    if (gone.empty()) return;
    const auto copies = store.take_shadows();
    for (std::size_t k = gone.size(); k-- > 0;) store.remove_local(gone[k]);
    store.append_from(copies, 0, copies.size());
  });

  using stored_entry = typename world_state<Scenario>::history_type::entry;
  const auto there = leaving.empty() ? bodies_elsewhere(0) : movable_copies(s);
  const id_table places(leaving, [](const auto& one) { return one.first; });
  const std::size_t stays = s.neighbour_messages.size();
  const auto find = [&](system_id id) {
    const auto at = places.find(id);
    return at == id_table::unknown ? stays : leaving[at].second;
  };
  each_migrating_history(s, [&](const auto& history) {
    std::vector<plain_vector<stored_entry>> to(s.neighbour_messages.size());
    if (!leaving.empty())
      for (const stored_entry& c : history.entries()) {
        const auto a = find(c.key.a), b = find(c.key.b);
        if (a < to.size() && !there.owns(a, c.key.b)) to[a].push_back(c);
        if (b < to.size() && b != a && !there.owns(b, c.key.a)) to[b].push_back(c);
      }
    for (std::size_t n = 0; n < to.size(); ++n)
      byte_writer(s.neighbour_messages[n].out).put(std::span<const stored_entry>(to[n]));
  });
  bool new_joints = !leaving.empty();
  if constexpr (world_state<Scenario>::has_joints)
    new_joints = send_joints(s, after_step, find) || new_joints;

  for (std::size_t n = 0; n < s.neighbour_messages.size(); ++n) seal_message(s, n, true);
  s.link->start(s.neighbour_messages);
  s.link->finish(s.neighbour_messages);

  std::size_t passing = 0;
  arrivals came;
  for (std::size_t n = 0; n < s.neighbour_messages.size(); ++n) {
    byte_reader in = read_message(s, n, true);
    s.each_finite_shape([&](auto& b) {
      auto count = in.get<std::uint64_t>();
      if (count == 0) return;
      const auto copies = b.movable.take_shadows();
      for (; count > 0; --count) {
        const bool ends_here = in.get<bool>();
        b.movable.unpack(in);
        const std::size_t i = b.movable.locals++;
        const system_id id = b.movable.id[i];
        came.all.push_back({id, static_cast<std::uint32_t>(n)});
        s.neighbours[n].channel.taken.add(id);
        s.owned.add(id);
        if (b.movable.flags[i] & flag_released) note_release(s, b.movable, i);
        if (s.own.contains(b.movable.position[i])) continue;
        ++passing;
        if (ends_here) refuse_foreign(s, id, b.movable.position[i], n);
      }
      b.movable.append_from(copies, 0, copies.size());
    });
    const auto receive = [&](auto& history) {
      for (const stored_entry& c : in.get_all<stored_entry>())
        if (!has_more_histories<Scenario> || history.find(c.key) == nullptr)
          history.add_arrived(c.key, c.memory);
    };
    each_migrating_history(s, receive);
    if constexpr (world_state<Scenario>::has_joints)
      new_joints = receive_joints(s, in) || new_joints;
    close_message(s, n, in);
  }
  if constexpr (world_state<Scenario>::has_joints)
    if (new_joints && s.joints.size() > 0) keep_own_joints(s, after_step);
  require_new(s, came);
  return passing;
}

/// The migration at the end of a step.
template <class Scenario>
void migrate_and_refresh(world_state<Scenario>& s) {
  run_hooks<ghost_stages::before_ghosts>(s);
  if constexpr (!world_state<Scenario>::link_type::alone) {
    const stage_clock clock(s.seconds.exchange);
    match_connections(s);
    refuse_closed_faces(s, true);
    migrate(s, true);
    if constexpr (!world_state<Scenario>::law::soft) s.travelled = s.travelling;
    share_shadow_copies(s, true);
  } else {
    require_all_here(s);
    run_hooks<ghost_stages::ghosts_renewed>(s);
  }
  s.note_changes_sent();
  run_hooks<ghost_stages::after_ghosts>(s);
}

/// At the beginning of a step: sends the user's changes since the last one to the neighbours.
template <class Scenario>
void notify_neighbours(world_state<Scenario>& s) {
  run_hooks<ghost_stages::before_ghosts>(s);
  if constexpr (!world_state<Scenario>::link_type::alone) {
    const stage_clock clock(s.seconds.exchange);
    match_connections(s);
    if (s.changed) refuse_closed_faces(s, false);
    // A body that the user moved far goes to its owner, so that contacts there are found.
    if (s.by_colours()) {
      const body_count before = s.owned;
      if (const std::size_t passing = migrate(s, false); passing > 0)
        fail<std::runtime_error>(
            "{} bodies that were moved since the last step are on their way through rank {} still: "
            "call synchronize() on all ranks after moving bodies farther than to a neighbour",
            passing, s.link->rank());
      s.changed = s.changed || !(s.owned == before);
    }
    // The first round sends how far bodies fly now, or how large the user's new bodies are; the
    // second uses it. (In other places contacts with these may start a step late, as those with
    // bodies that a collision made faster than any known body.)
    if (world_state<Scenario>::continuous || s.by_colours()) {
      plain_vector<real> before;
      for (const auto& n : s.neighbours) before.push_back(n.reach);
      share_shadow_copies(s, s.changed);
      for (std::size_t n = 0; n < before.size(); ++n)
        s.changed = s.changed || s.neighbours[n].reach > before[n];
      if (s.by_colours()) s.changed = s.changed || !reach_still_holds(s);
    }
    share_shadow_copies(s, s.changed);
    refuse_uncovered_flights(s);
  } else {
    run_hooks<ghost_stages::ghosts_renewed>(s);
  }
  s.note_changes_sent();
  run_hooks<ghost_stages::after_ghosts>(s);
}

}  // namespace talus::detail
