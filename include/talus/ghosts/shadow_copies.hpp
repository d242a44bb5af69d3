#pragma once
// Shadow copies: which bodies the neighbours need, and how they receive them.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/ghosts/conservation.hpp"
#include "talus/ghosts/coverage.hpp"
#include "talus/ghosts/released.hpp"
#include "talus/ghosts/stages.hpp"
#include "talus/solver/direct/body_ties.hpp"
#include "talus/state/acting_range.hpp"
#include "talus/state/body_numbers.hpp"
#include "talus/state/hooks.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Finds the ranks that hold copies of own fixed bodies.
template <class Scenario>
void find_holders(world_state<Scenario>& s) {
  using code = typename world_state<Scenario>::copy_code;
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    auto& own = s.known_fixed.own[k];
    own.clear();
    for (const auto& n : s.neighbours)
      for (const auto copy : n.shadowed[k])
        if (const auto i = code::body(copy); b.movable.fixed(i)) {
          own.emplace_back(i, body_holders{});
          own.back().second.add(n.rank);
        }
    ++k;
    if (own.empty()) return;
    std::stable_sort(own.begin(), own.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    std::size_t last = 0;
    for (std::size_t m = 1; m < own.size(); ++m)
      if (own[m].first == own[last].first)
        own[last].second.add(own[m].second);
      else
        own[++last] = own[m];
    own.resize(last + 1);
  });
}

/// Lists the fixed bodies that several ranks know, and the ranks that hold their copies.
template <class Scenario>
void list_known_fixed_bodies(world_state<Scenario>& s) {
  auto& all = s.known_fixed.all;
  all.clear();
  plain_vector<std::size_t> next(s.neighbours.size(), 0);
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    for (const auto& [i, holders] : s.known_fixed.own[k])
      all.push_back({static_cast<std::uint32_t>(b.first + i), s.link->rank(), holders});
    std::size_t copy = b.movable.locals;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n)
      for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c, ++copy)
        if (b.movable.fixed(copy) && next[n] < s.neighbours[n].holders.size())
          all.push_back({static_cast<std::uint32_t>(b.first + copy), s.neighbours[n].rank,
                         s.neighbours[n].holders[next[n]++]});
    ++k;
  });
}

/// Lists the solver indices of the bodies whose velocities are exchanged in each iteration.
template <class Scenario>
void list_travelling_velocities(world_state<Scenario>& s) {
  s.at_border.assign(number_bodies(s).all, false);
  s.travelling.resize(s.neighbours.size());
  for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
    s.travelling[n].rank = s.neighbours[n].rank;
    s.travelling[n].sent.clear(), s.travelling[n].received.clear();
  }
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    std::size_t copy = b.movable.locals;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
      if constexpr (world_state<Scenario>::periodic)
        if (s.neighbours[n].rank == s.own.rank()) {  // these are here
          copy += s.neighbours[n].copies[k];
          continue;
        }
      for (const auto code : s.neighbours[n].shadowed[k])
        if (const auto i = world_state<Scenario>::copy_code::body(code); b.movable.moves(i)) {
          s.travelling[n].sent.push_back(static_cast<std::uint32_t>(b.first + i));
          s.at_border[b.first + i] = true;
        }
      for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c, ++copy)
        if (b.movable.moves(copy))
          s.travelling[n].received.push_back(static_cast<std::uint32_t>(b.first + copy));
    }
    ++k;
  });
  // If there is nothing to send, the other side has nothing to send either.
  std::erase_if(s.travelling,
                [](const auto& other) { return other.sent.empty() && other.received.empty(); });
  s.velocity_messages.clear();
  for (const auto& other : s.travelling) s.velocity_messages.push_back({.rank = other.rank});
}

/// The reach of a body until the next copies are made. Soft contacts are found at the positions of
/// the copies, hard ones after up to one more step.
template <class Scenario, class Store>
[[nodiscard]] real shadow_reach(const world_state<Scenario>& s, const Store& store, std::size_t i) {
  ghost_stages::horizon ahead{
      .time = world_state<Scenario>::law::soft ? 0 : world_state<Scenario>::steps_of_reach * s.dt};
  run_hooks<ghost_stages::ghost_reach>(s, ahead);
  return reach_of(store, i, ahead.time) + ahead.further + acting_range(s, store, i);
}

/// Shifts a received copy from its position at the owner to its image on this rank.
template <class Scenario>
void put_image(const rank_state<Scenario>& s, vec3& position, image_copy& copy) {
  copy.home = position;
  if (copy.image != 0) position += s.own.box().shift(copy.image);
}

/// Reads the motion of the copies of neighbour n from `in[n]`, unless that is null.
template <class Scenario>
void move_shadow_copies(population<Scenario>& s, const std::vector<byte_reader*>& in) {
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    std::size_t i = b.movable.locals;
    for (std::size_t n = 0; n < in.size(); ++n)
      for (std::size_t c = 0; c < s.neighbours[n].copies[k]; ++c, ++i)
        if (in[n] != nullptr) {
          b.movable.unpack_motion(i, *in[n]);
          if constexpr (state_traits<Scenario>::periodic)
            put_image(s, b.movable.position[i], s.copies.of[k][i - b.movable.locals]);
        }
    ++k;
  });
}

/// Rebuilds the shadow copies of all shapes: those of neighbour n are read from `in[n]`, or kept if
/// `in[n]` is null; `before[n]` is their number, by shape.
template <class Scenario, class Counts>
void rebuild_shadow_copies(world_state<Scenario>& s, const plain_vector<Counts>& before,
                           const std::vector<byte_reader*>& in) {
  const bool some_stay = std::find(in.begin(), in.end(), nullptr) != in.end();
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    std::remove_reference_t<decltype(b.movable)> old;
    if (some_stay)
      old = b.movable.take_shadows();
    else
      b.movable.drop_shadows();
    plain_vector<image_copy> old_images;
    if constexpr (world_state<Scenario>::periodic) old_images.swap(s.copies.of[k]);
    std::size_t first = 0;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n) {
      if (in[n] == nullptr) {
        b.movable.append_from(old, first, first + before[n][k]);
        if constexpr (world_state<Scenario>::periodic)
          for (std::size_t c = first; c < first + before[n][k]; ++c)
            s.copies.of[k].push_back(old_images[c]);
      } else {
        const auto copies = in[n]->template get<std::uint64_t>();
        for (std::uint64_t c = 0; c < copies; ++c) {
          b.movable.unpack_copy(*in[n]);
          if constexpr (world_state<Scenario>::periodic) {
            image_copy& copy = s.copies.of[k].emplace_back();
            copy.image = in[n]->template get<std::uint8_t>();
            if (s.neighbours[n].rank == s.own.rank())
              copy.own = world_state<Scenario>::copy_code::body(s.neighbours[n].shadowed[k][c]);
            put_image(s, b.movable.position.back(), copy);
          }
          if (b.movable.flags.back() & flag_released) clear_history_of(s, b.movable.id.back());
        }
        s.neighbours[n].copies[k] = copies;
      }
      first += before[n][k];
    }
    ++k;
  });
}

/// How much of its bodies a rank sends to the holders of their copies.
enum class copy_message : std::uint8_t { nothing, motion, all };

/// Whether no reach on other ranks exceeds that at the last choice of copies.
template <class Scenario>
[[nodiscard]] bool reach_still_holds(const rank_state<Scenario>& s) {
  if constexpr (state_traits<Scenario>::continuous) return false;  // reach is that of each flight
  const plain_vector<real>& then = s.choice.reach;
  return std::equal(s.neighbours.begin(), s.neighbours.end(), then.begin(), then.end(),
                    [](const auto& n, real reach) { return n.reach <= reach; });
}

/// Whether the copies chosen last are still complete: the same bodies in the same order, none of
/// which leaves its skin.
template <class Scenario>
[[nodiscard]] bool copies_still_hold(const population<Scenario>& s) {
  bool hold = reach_still_holds(s);
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    if (!hold) return;
    const auto& store = b.movable;
    const auto& noted = s.choice.bodies[k++];
    hold = store.locals == noted.size();
    for (std::size_t i = 0; hold && i < store.locals; ++i)
      hold = noted[i].covers(store.id[i], store.position[i], b.reach[i]);
  });
  return hold;
}

/// Throws runtime_error for a body that could touch another one in two images, or itself.
template <class Scenario, class Store>
void require_room_for_images(const world_state<Scenario>& s, const Store& store, std::size_t i,
                             real reach) {
  const real room = s.own.box().shortest();
  if (4 * reach <= room) return;
  fail<std::runtime_error>(
      "the {} {} at {} on rank {} reaches {} far in step {}, by its radius {} and velocity {}, and "
      "the periodic box is only {} long: bodies reach at most a quarter of it, so that two meet in "
      "one image only; make the box larger, or dt smaller",
      Store::shape_type::name, store.id[i], text(store.position[i]), s.link->rank(), text(reach, 4),
      s.steps, text(store.shape[i].bounding_radius(), 4), store.velocity[i], room);
}

/// Chooses for every neighbour the copies it needs: each body here that may touch one of its
/// bodies, that is, whose distance from its domain is at most the sum of its own reach and the
/// largest reach there. (So both owners of a touching pair hold a copy of the other body, wherever
/// the contact point lies.) Earlier choices stay for bodies that are within their skin.
template <class Scenario>
void choose_copies(world_state<Scenario>& s) {
  using code = typename world_state<Scenario>::copy_code;
  const bool some_stay = reach_still_holds(s);
  real furthest = 0;
  s.choice.reach.clear();
  for (const auto& n : s.neighbours) {
    furthest = std::max(furthest, n.reach);
    s.choice.reach.push_back(n.reach);
  }
  std::size_t k = 0;
  s.each_finite_shape([&](auto& b) {
    const auto& store = b.movable;
    auto& noted = s.choice.bodies[k];
    plain_vector<std::uint32_t> was, now;
    if (some_stay) {
      was = numbers_before(noted, std::span(store.id).first(store.locals));
      now = numbers_now(was, noted.size());
    }
    plain_vector<noted_body> before(world_state<Scenario>::continuous ? 0 : store.locals);
    before.swap(noted);
    const auto stays = [&](std::size_t i) {
      return some_stay && was[i] != nobody &&
             before[was[i]].covers(store.id[i], store.position[i], b.reach[i]);
    };
    for (auto& n : s.neighbours) {
      auto& list = n.shadowed[k];
      std::size_t kept = 0;
      for (const std::uint32_t old : list)
        if (const auto i = some_stay ? now[code::body(old)] : nobody; i != nobody && stays(i))
          list[kept++] = code::of(i, code::image(old));
      list.resize(kept);
    }
    for (std::size_t i = 0; i < store.locals; ++i) {
      if (stays(i)) {
        noted[i] = before[was[i]];
        continue;
      }
      const vec3& p = store.position[i];
      real reach = b.reach[i];
      if constexpr (!world_state<Scenario>::continuous) {
        const real radius = store.shape[i].bounding_radius();
        reach += skin_of(radius, radius, store.velocity[i].norm(), s.dt);
        noted[i] = {store.id[i], p, reach};
      }
      const auto copy = [&](std::size_t n, std::uint32_t image, const vec3& place) {
        auto& other = s.neighbours[n];
        // A force that is missing for a step is an error: a large body may just have arrived there.
        const real there = world_state<Scenario>::law::soft ? furthest : other.reach;
        if (s.own.connections()[n].distance(place) <= reach + there)
          other.shadowed[k].push_back(code::of(i, image));
      };
      if constexpr (world_state<Scenario>::periodic) {
        require_room_for_images(s, store, i, b.reach[i]);
        s.own.for_each_image_within(p, reach + furthest, copy);
      } else {
        s.own.for_each_within(p, reach + furthest, [&](std::size_t n) { copy(n, 0, p); });
      }
    }
    for (auto& n : s.neighbours) sort_values(n.shadowed[k]);
    ++k;
  });
}

/// Measures the reach of bodies, and the value that neighbours receive: above the present reach, so
/// that it changes rarely.
template <class Scenario>
void measure_reach(world_state<Scenario>& s) {
  update_ranges(s);
  real largest = 0;
  const real covered = s.own.covered();
  s.each_finite_shape([&](auto& b) {
    b.reach.resize(b.movable.size());
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      b.reach[i] = shadow_reach(s, b.movable, i);
      largest = std::max(largest, b.reach[i]);  // a copy here may be owned in a step
      const real range = acting_range(s, b.movable, i);
      if (i < b.movable.locals && b.movable.shape[i].bounding_radius() + range > covered)
        require_reached(s, b.movable.id[i], b.movable.shape[i], b.movable.position[i], range);
    }
  });
  if constexpr (world_state<Scenario>::has_joints) reach_jointed(s);
  real& said = s.choice.announced;
  if (world_state<Scenario>::continuous)
    said = largest;
  else if (!(largest <= said && said <= real(1.2) * largest))
    said = real(1.05) * largest;
}

/// The message to neighbour `n` about the bodies of which it holds copies.
template <class Scenario>
void pack_copies(world_state<Scenario>& s, std::size_t n, copy_message kind) {
  using code = typename world_state<Scenario>::copy_code;
  open_message(s, n);
  byte_writer out(s.neighbour_messages[n].out, s.neighbours[n].shared());
  out.put(s.choice.announced);
  out.put(kind);
  run_hooks<ghost_stages::pack_notice>(s, out);
  if constexpr (world_state<Scenario>::filters)
    out.put(static_cast<std::uint8_t>(s.filtered.changed));
  copies_reported told;
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    for (const auto copy : s.neighbours[n].shadowed[k]) told.add(b.movable.id[code::body(copy)]);
    ++k;
  });
  out.put(told);
  k = 0;
  s.each_finite_shape([&](auto& b) {
    const auto& shadowed = s.neighbours[n].shadowed[k++];
    if (kind == copy_message::all) {
      out.put(static_cast<std::uint64_t>(shadowed.size()));
      for (const auto copy : shadowed) {
        b.movable.pack_copy(code::body(copy), out);
        if constexpr (world_state<Scenario>::periodic)
          out.put(static_cast<std::uint8_t>(code::image(copy)));
      }
    } else if (kind == copy_message::motion) {
      for (const auto copy : shadowed) b.movable.pack_motion(code::body(copy), out);
    }
  });
  if constexpr (world_state<Scenario>::islands_across_ranks)
    if (kind == copy_message::all) {
      plain_vector<body_holders> holders;
      k = 0;
      s.each_finite_shape([&](const auto& b) {
        const auto& own = s.known_fixed.own[k];
        for (const auto copy : s.neighbours[n].shadowed[k++])
          if (const auto i = code::body(copy); b.movable.fixed(i))
            holders.push_back(
                std::lower_bound(own.begin(), own.end(), i, [](const auto& x, auto y) {
                  return x.first < y;
                })->second);
      });
      out.put(std::span<const body_holders>(holders));
    }
  seal_message(s, n, false);
}

/// Refreshes the copies that neighbours hold. The choice of copies changes only when necessary, so
/// that they keep their order, and only the data that a step changes are sent again. With `anew`
/// false nothing has changed here, and the message contains only that.
template <class Scenario>
void share_shadow_copies(world_state<Scenario>& s, bool anew) {
  bool changed = s.changed;
  run_hooks<ghost_stages::flags_changed>(s, changed);
  measure_reach(s);
  auto mine = copy_message::nothing;
  if (anew || changed) {
    mine = changed ? copy_message::all : copy_message::motion;
    if (!copies_still_hold(s)) choose_copies(s), mine = copy_message::all;
  }
  if constexpr (world_state<Scenario>::islands_across_ranks)
    if (mine == copy_message::all) find_holders(s);
  for (std::size_t n = 0; n < s.neighbour_messages.size(); ++n) pack_copies(s, n, mine);
  if (mine == copy_message::all) end_releases(s);

  s.link->start(s.neighbour_messages);
  s.link->finish(s.neighbour_messages);

  std::vector<byte_reader> in;
  std::vector<byte_reader*> moved, renewed;
  plain_vector<std::array<std::size_t, world_state<Scenario>::shape_count>> before;
  plain_vector<copies_reported> told;
  in.reserve(s.neighbour_messages.size());
  bool any = mine == copy_message::all;
  for (std::size_t n = 0; n < s.neighbour_messages.size(); ++n) {
    byte_reader& message = in.emplace_back(read_message(s, n, false));
    s.neighbours[n].reach = message.template get<real>();
    const auto kind = message.template get<copy_message>();
    run_hooks<ghost_stages::unpack_notice>(s, message);
    if constexpr (world_state<Scenario>::filters)
      if (message.template get<std::uint8_t>() != 0) s.found.known = false;
    told.push_back(message.template get<copies_reported>());
    moved.push_back(kind == copy_message::motion ? &message : nullptr);
    renewed.push_back(kind == copy_message::all ? &message : nullptr);
    before.push_back(s.neighbours[n].copies);
    any = any || kind == copy_message::all;
  }
  move_shadow_copies(s, moved);
  if (any) rebuild_shadow_copies(s, before, renewed);
  if constexpr (world_state<Scenario>::islands_across_ranks)
    for (std::size_t n = 0; n < in.size(); ++n)
      if (renewed[n] != nullptr) {
        s.neighbours[n].holders.clear();
        for (const body_holders& one : in[n].template get_all<body_holders>())
          s.neighbours[n].holders.push_back(one);
      }
  for (std::size_t n = 0; n < in.size(); ++n) close_message(s, n, in[n]);
  require_copies(s, told);
  if (!any) return;
  require_one_owner(s);
  if constexpr (!world_state<Scenario>::law::soft) list_travelling_velocities(s);
  if constexpr (world_state<Scenario>::islands_across_ranks) list_known_fixed_bodies(s);
  run_hooks<ghost_stages::ghosts_renewed>(s);
}

}  // namespace talus::detail
