#pragma once
// Last stage of a step: bodies whose centre has left go to their new owner, and shadow copies are
// made anew on every rank whose bodies they may touch.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/world/closed_faces.hpp"
#include "talus/world/coverage.hpp"
#include "talus/world/sleeping_islands.hpp"
#include "talus/world/state.hpp"

namespace talus::detail {

struct body_counts {
  std::size_t scalar = 0, all = 0;
};

/// Gives each shape its range in the arrays of the response: scalar inertia first, then tensors.
/// The arrays themselves keep what the last step left until the next one begins.
template <class Scenario>
body_counts number_bodies(world_state<Scenario>& s) {
  std::size_t next = 0;
  const auto number = [&](auto& b, bool tensors) {
    if (std::remove_cvref_t<decltype(b.movable)>::tensor != tensors) return;
    b.first = next;
    next += b.movable.size();
  };
  s.each_finite_shape([&](auto& b) { number(b, false); });
  const std::size_t scalar = next;
  s.each_finite_shape([&](auto& b) { number(b, true); });
  return {scalar, next};
}

/// Rebuilds the shadow copies of all shapes: those of neighbour n are taken from `in[n]`, or stay
/// as they are where `in[n]` is null; `before[n]` says how many there were, by shape.
template <class Scenario, class Counts>
void rebuild_shadow_copies(world_state<Scenario>& s, const plain_vector<Counts>& before,
                           std::vector<byte_reader*> in) {
  const bool some_stay = std::find(in.begin(), in.end(), nullptr) != in.end();
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    std::remove_reference_t<decltype(b.movable)> old;
    if (some_stay)
      for (std::size_t i = b.movable.locals; i < b.movable.size(); ++i)
        old.append_from(b.movable, i);
    b.movable.drop_shadows();
    std::size_t first = 0;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
      if (in[n] == nullptr) {
        for (std::size_t c = 0; c < before[n][k]; ++c) b.movable.append_from(old, first + c);
      } else {
        const auto copies = in[n]->template get<std::uint64_t>();
        for (std::uint64_t c = 0; c < copies; ++c) b.movable.unpack(*in[n]);
        s.neighbours[n].copies[k] = copies;
      }
      first += before[n][k];
    }
    ++k;
  });
}

/// Takes up connections made or removed since the last handover. Copies of bodies of ranks that are
/// no longer connected go; the others are told anew at once.
template <class Scenario>
void match_connections(world_state<Scenario>& s) {
  const auto connections = s.own.connections();
  if (std::equal(connections.begin(), connections.end(), s.neighbours.begin(), s.neighbours.end(),
                 [](const auto& c, const auto& n) { return c.rank == n.rank; }))
    return;
  auto before = std::exchange(s.neighbours, {});
  s.parcels.clear();
  for (const auto& c : connections) {
    const auto old =
        std::find_if(before.begin(), before.end(), [&](const auto& n) { return n.rank == c.rank; });
    auto& now = s.neighbours.emplace_back();
    if (old != before.end()) now = std::move(*old);
    now.rank = c.rank;
    s.parcels.push_back({.rank = c.rank});
  }
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    std::remove_reference_t<decltype(b.movable)> kept;
    std::size_t i = b.movable.locals;
    for (const auto& n : before) {
      const bool stays = s.own.find(n.rank) != nullptr;
      for (std::size_t c = 0; c < n.copies[k]; ++c, ++i)
        if (stays) kept.append_from(b.movable, i);
    }
    b.movable.drop_shadows();
    for (std::size_t c = 0; c < kept.size(); ++c) b.movable.append_from(kept, c);
    ++k;
  });
  s.changed = true;
}

/// Index of the connection towards the owner of `p`: itself, or a neighbour nearer to it.
template <class Scenario>
[[nodiscard]] std::size_t way_to(const world_state<Scenario>& s, const vec3& p) {
  const auto connections = s.own.connections();
  const int owner = s.own.owner(p);
  std::size_t best = 0;
  for (std::size_t n = 0; n < connections.size(); ++n) {
    if (connections[n].rank == owner) return n;
    if (connections[n].distance(p) < connections[best].distance(p)) best = n;
  }
  return best;
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

/// How far a body reaches until the next copies are made. Soft contacts are found where the copies
/// are, hard ones where they might be a step later.
template <class Scenario, class Store>
[[nodiscard]] real shadow_reach(const world_state<Scenario>& s, const Store& store, std::size_t i) {
  if constexpr (world_state<Scenario>::sleeps)  // a contact outlives the motion it was found in
    return reach_of(store, i, steps_of_warning * s.dt) + 4 * s.dt * s.sleep.settings.speed;
  else
    return reach_of(store, i, world_state<Scenario>::law::soft ? 0 : s.dt);
}

/// Sends bodies whose centre has left to their new owner, with the memory of their contacts.
/// Returns the number of bodies that this rank still holds for others (only where the way to their
/// owner is longer than one connection).
template <class Scenario>
std::size_t migrate(world_state<Scenario>& s) {
  plain_vector<std::pair<system_id, std::size_t>> leaving;
  for (parcel& p : s.parcels) p.out.clear();
  for (auto& n : s.neighbours) n.next_exchange();
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    store.drop_shadows();
    plain_vector<std::size_t> gone;
    std::vector<plain_vector<std::size_t>> to(s.parcels.size());
    for (std::size_t i = 0; i < store.locals; ++i) {
      const vec3& p = store.position[i];
      if (!finite(p)) fail_lost(s, store.id[i], p);
      if (s.own.contains(p)) continue;
      if (s.parcels.empty()) fail_lost(s, store.id[i], p);
      const auto n = way_to(s, p);
      to[n].push_back(i);
      gone.push_back(i);
      leaving.emplace_back(store.id[i], n);
      if constexpr (world_state<Scenario>::law::soft)
        s.neighbours[n].reach = std::max(s.neighbours[n].reach, shadow_reach(s, store, i));
    }
    for (std::size_t n = 0; n < to.size(); ++n) {
      byte_writer out(s.parcels[n].out, s.neighbours[n].shared());
      out.put(static_cast<std::uint64_t>(to[n].size()));
      for (const auto i : to[n]) store.pack(i, out);
    }
    for (std::size_t k = gone.size(); k-- > 0;) store.remove_local(gone[k]);
  });

  using remembered = typename world_state<Scenario>::history_type::entry;
  std::vector<plain_vector<remembered>> memories(s.parcels.size());
  std::vector<plain_vector<remembered>> frozen(world_state<Scenario>::sleeps ? s.parcels.size()
                                                                             : 0);
  if (!leaving.empty()) {
    sort_values(leaving);
    const auto find = [&](system_id id) {
      const auto at =
          std::lower_bound(leaving.begin(), leaving.end(), std::pair{id, std::size_t{0}});
      return at != leaving.end() && at->first == id ? at->second : memories.size();
    };
    const auto send = [&](const auto& history, auto& to) {
      for (const remembered& c : history.entries()) {
        const auto a = find(c.key.a), b = find(c.key.b);
        if (a < to.size()) to[a].push_back(c);
        if (b < to.size() && b != a) to[b].push_back(c);
      }
    };
    send(s.history, memories);
    if constexpr (world_state<Scenario>::sleeps) send(s.sleep.contacts, frozen);
  }
  for (std::size_t n = 0; n < memories.size(); ++n)
    byte_writer(s.parcels[n].out).put(std::span<const remembered>(memories[n]));
  for (std::size_t n = 0; n < frozen.size(); ++n)
    byte_writer(s.parcels[n].out).put(std::span<const remembered>(frozen[n]));

  s.link->start(s.parcels);
  s.link->finish(s.parcels);

  std::size_t passing = 0;
  for (std::size_t n = 0; n < s.parcels.size(); ++n) {
    byte_reader in(s.parcels[n].in, s.neighbours[n].shared());
    s.each_finite_shape([&](auto& b) {
      for (auto count = in.get<std::uint64_t>(); count > 0; --count) {
        b.movable.unpack(in);
        passing += !s.own.contains(b.movable.position[b.movable.locals++]);
      }
    });
    const auto receive = [&](auto& history) {
      for (const remembered& c : in.get_all<remembered>())
        if (history.find(c.key) == nullptr) history.add(c.key, c.memory);
    };
    receive(s.history);
    if constexpr (world_state<Scenario>::sleeps) receive(s.sleep.contacts);
  }
  return passing;
}

/// Lists the solver indices of the bodies whose velocities travel in each iteration.
template <class Scenario>
void list_travelling_velocities(world_state<Scenario>& s) {
  number_bodies(s);
  s.travelling.resize(s.neighbours.size());
  for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
    s.travelling[n].rank = s.neighbours[n].rank;
    s.travelling[n].sent.clear(), s.travelling[n].received.clear();
  }
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    std::size_t copy = b.movable.locals;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
      for (const auto i : s.neighbours[n].shadowed[k])
        if (b.movable.moves(i))
          s.travelling[n].sent.push_back(static_cast<std::uint32_t>(b.first + i));
      for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c, ++copy)
        if (b.movable.moves(copy))
          s.travelling[n].received.push_back(static_cast<std::uint32_t>(b.first + copy));
    }
    ++k;
  });
  // Where there is nothing to say, there is nothing to say on the other side either.
  std::erase_if(s.travelling,
                [](const auto& other) { return other.sent.empty() && other.received.empty(); });
  s.velocity_parcels.clear();
  for (const auto& other : s.travelling) s.velocity_parcels.push_back({.rank = other.rank});
}

/// Sends every neighbour the copies it needs: of each body here that may touch one of its bodies,
/// that is, whose distance from its domain is within the sum of its own reach and the largest
/// reach there. (So both owners of a pair that touches hold a copy of the other, wherever the
/// contact point lies.) With `anew` false nothing has changed here, and only that is said.
template <class Scenario>
void share_shadow_copies(world_state<Scenario>& s, bool anew) {
  if constexpr (world_state<Scenario>::sleeps) anew = anew || s.sleep.changed;
  real largest = 0;
  const real covered = s.own.covered();
  s.each_finite_shape([&](auto& b) {
    b.reach.resize(b.movable.size());
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      b.reach[i] = shadow_reach(s, b.movable, i);
      largest = std::max(largest, b.reach[i]);
      if (i < b.movable.locals && b.movable.shape[i].bounding_radius() > covered)
        require_reached(s, b.movable.id[i], b.movable.shape[i], b.movable.position[i]);
    }
  });
  real furthest = 0;
  for (const auto& n : s.neighbours) furthest = std::max(furthest, n.reach);
  std::size_t k = 0;
  if (anew)
    s.each_finite_shape([&](auto& b) {
      for (auto& n : s.neighbours) n.shadowed[k].clear();
      for (std::size_t i = 0; i < b.movable.locals; ++i) {
        const vec3& p = b.movable.position[i];
        s.own.for_each_within(p, b.reach[i] + furthest, [&](std::size_t n) {
          auto& other = s.neighbours[n];
          // A force that is missing for a step is an error: a large body may just have gone there.
          const real there = world_state<Scenario>::law::soft ? furthest : other.reach;
          if (s.own.connections()[n].distance(p) <= b.reach[i] + there)
            other.shadowed[k].push_back(static_cast<std::uint32_t>(i));
        });
      }
      ++k;
    });
  for (std::size_t n = 0; n < s.parcels.size(); ++n) {
    s.parcels[n].out.clear();
    s.neighbours[n].next_exchange();
    byte_writer out(s.parcels[n].out, s.neighbours[n].shared());
    out.put(largest);
    out.put(static_cast<std::uint8_t>(anew));
    if constexpr (world_state<Scenario>::sleeps)
      out.put(static_cast<std::uint8_t>(s.sleep.changed));
    if (!anew) continue;
    k = 0;
    s.each_finite_shape([&](auto& b) {
      const auto& shadowed = s.neighbours[n].shadowed[k++];
      out.put(static_cast<std::uint64_t>(shadowed.size()));
      for (const auto i : shadowed) b.movable.pack(i, out);
    });
  }

  s.link->start(s.parcels);
  s.link->finish(s.parcels);

  std::vector<byte_reader> in;
  std::vector<byte_reader*> renewed;
  plain_vector<std::array<std::size_t, world_state<Scenario>::shape_count>> before;
  in.reserve(s.parcels.size());
  bool any = anew;
  for (std::size_t n = 0; n < s.parcels.size(); ++n) {
    byte_reader& message = in.emplace_back(s.parcels[n].in, s.neighbours[n].shared());
    s.neighbours[n].reach = message.template get<real>();
    const bool new_here = message.template get<std::uint8_t>() != 0;
    if constexpr (world_state<Scenario>::sleeps)
      s.sleep.changed |= message.template get<std::uint8_t>() != 0;
    renewed.push_back(new_here ? &message : nullptr);
    before.push_back(s.neighbours[n].copies);
    any = any || new_here;
  }
  if (!any) return;
  rebuild_shadow_copies(s, before, renewed);
  if constexpr (!world_state<Scenario>::law::soft) list_travelling_velocities(s);
  if constexpr (world_state<Scenario>::sleeps)
    if (std::exchange(s.sleep.changed, false)) note_sleepers(s);
}

/// The handover at the end of a step.
template <class Scenario>
void hand_over(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::sleeps) wake_islands(s);
  if constexpr (!world_state<Scenario>::link_type::alone) {
    const stage_clock clock(s.seconds.exchange);
    match_connections(s);
    refuse_closed_faces(s, true);
    migrate(s);
    if constexpr (!world_state<Scenario>::law::soft) s.travelled.swap(s.travelling);
    share_shadow_copies(s, true);
  } else if constexpr (world_state<Scenario>::sleeps) {
    if (std::exchange(s.sleep.changed, false)) note_sleepers(s);
  }
  s.changed = false;
}

/// At the beginning of a step: tells the neighbours what the user has changed since the last one.
template <class Scenario>
void announce_changes(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::sleeps) wake_islands(s);
  if constexpr (!world_state<Scenario>::link_type::alone) {
    const stage_clock clock(s.seconds.exchange);
    match_connections(s);
    if (s.changed) refuse_closed_faces(s, false);
    if constexpr (world_state<Scenario>::continuous) {
      // The first round tells how far bodies fly now, the second acts on it.
      plain_vector<real> before;
      for (const auto& n : s.neighbours) before.push_back(n.reach);
      share_shadow_copies(s, s.changed);
      for (std::size_t n = 0; n < before.size(); ++n)
        s.changed = s.changed || s.neighbours[n].reach > before[n];
    }
    share_shadow_copies(s, s.changed);
  } else if constexpr (world_state<Scenario>::sleeps) {
    if (std::exchange(s.sleep.changed, false)) note_sleepers(s);
  }
  s.changed = false;
}

}  // namespace talus::detail
