#pragma once
// Conservation of bodies: the bodies of a rank are those that it owned before and those that
// arrived since; an arriving body is new here and has reached its owner; and copies match the list
// of their owner. Each rank checks this on its own in every step; the first missing or duplicate
// body ends the run with its id.
#include <cstdint>
#include <string>
#include <type_traits>

#include "talus/core/id_set.hpp"
#include "talus/ghosts/messages.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The bodies that are owned here.
template <class Scenario>
[[nodiscard]] body_count count_owned(const held_bodies<Scenario>& s) {
  body_count here;
  s.each_finite_shape([&](const auto& b) {
    std::uint64_t ids = 0;
    for (std::size_t i = 0; i < b.movable.locals; ++i) ids += value_of(b.movable.id[i]);
    here = here + body_count{b.movable.locals, ids};
  });
  return here;
}

/// Bodies came here by other means than those of the world, as from a file, on all ranks: the
/// bodies here become the reference.
template <class Scenario>
void take_stock(population<Scenario>& s) {
  s.owned = s.made = count_owned(s);
}

/// A body that is owned here more than once, or no_id.
template <class Scenario>
[[nodiscard, gnu::cold]] system_id twice_owned(const held_bodies<Scenario>& s) {
  id_set known(count_owned(s).bodies);
  system_id twice = no_id;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      if (!known.insert(b.movable.id[i])) twice = b.movable.id[i];
  });
  return twice;
}

/// Throws runtime_error unless this rank owns the expected bodies.
template <class Scenario>
void require_all_here(const world_state<Scenario>& s) {
  const body_count here = count_owned(s);
  if (here == s.owned) return;
  const surplus difference(here, s.owned);
  const system_id twice = twice_owned(s);
  fail<std::runtime_error>(
      "{} {} in step {}: rank {} should own {} bodies, and owns {}; bodies come and go by add, "
      "fill "
      "and destroy only",
      twice != no_id ? "body " + text(twice) + last_seen(s, twice) : text(s, difference),
      twice != no_id          ? "is there twice"
      : difference.bodies > 0 ? "appeared from nowhere"
                              : "is lost",
      s.steps, s.link->rank(), s.owned.bodies, here.bodies);
}

/// The owner of a body, and its position, over all ranks. Collective; for messages.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string owners_text(const population<Scenario>& s, system_id id) {
  if constexpr (state_traits<Scenario>::link_type::alone)
    return "";
  else {
    byte_buffer mine;
    byte_writer out(mine);
    s.each_finite_shape([&](const auto& b) {
      for (std::size_t i = 0; i < b.movable.locals; ++i)
        if (b.movable.id[i] == id) out.put(b.movable.position[i]);
    });
    std::string owners;
    int rank = 0;
    for (const byte_buffer& theirs : s.link->gather_all(mine)) {
      for (byte_reader in(theirs); !in.empty();)
        owners += compose("{} rank {} at {}", owners.empty() ? "; it is owned by" : " and by", rank,
                          in.get<vec3>());
      ++rank;
    }
    return owners;
  }
}

/// The bodies that arrived in a migration, and the neighbour that sent them.
struct arrivals {
  struct one {
    system_id id;
    std::uint32_t from;
  };
  plain_vector<one> all;
};

/// Throws runtime_error if one of the arrived bodies is now owned here twice.
template <class Scenario>
void require_new(const world_state<Scenario>& s, const arrivals& came) {
  if (came.all.empty()) return;
  id_set ids(came.all.size());
  system_id twice = no_id;
  for (const auto& a : came.all)
    if (!ids.insert(a.id)) twice = a.id;
  std::size_t here = 0;
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i) here += ids.contains(b.movable.id[i]);
  });
  if (here == came.all.size() && twice == no_id) return;
  if (twice == no_id) twice = twice_owned(s);
  int from = -1;
  for (const auto& a : came.all)
    if (a.id == twice) from = s.neighbours[a.from].rank;
  fail<std::runtime_error>(
      "body {}{} came from rank {} to rank {} in step {}, which owns it already: it is there "
      "twice",
      twice, last_seen(s, twice), from, s.link->rank(), s.steps);
}

/// Throws runtime_error for a body that was sent to this rank as its owner although the
/// decomposition assigns it elsewhere. (If connections are made by hand, two ranks may place the
/// boundary between them differently. Then the body goes back, and is neither lost nor duplicated.)
template <class Scenario>
[[gnu::cold]] void refuse_foreign(const world_state<Scenario>& s, system_id id, const vec3& p,
                                  std::size_t from) {
  if (s.own.partition() == nullptr) return;
  const int owner = s.own.owner(p);
  fail<std::runtime_error>(
      "rank {} handed body {} at {} over to rank {} as its owner in step {}, but for rank {} the "
      "place belongs to {}: the two ranks have different domains in mind; decompose() alike on all "
      "ranks",
      s.neighbours[from].rank, id, p, s.link->rank(), s.steps, s.link->rank(),
      owner < 0 ? std::string("a rank that it is not connected to")
                : "rank " + std::to_string(owner));
}

/// The description of the copies that a neighbour should have: which bodies, and in which order.
struct copies_reported {
  body_count count;
  std::uint64_t order = 0;

  void add(system_id id) {
    count.add(id);
    order += count.bodies * value_of(id);
  }
  friend bool operator==(const copies_reported&, const copies_reported&) = default;
};

/// Throws runtime_error unless the copies here match the descriptions of the neighbours.
template <class Scenario>
void require_copies(const world_state<Scenario>& s, const plain_vector<copies_reported>& told) {
  plain_vector<copies_reported> here(s.neighbours.size());
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    std::size_t i = b.movable.locals;
    for (std::size_t n = 0; n < s.neighbours.size(); ++n)
      for (std::size_t c = 0; c < s.neighbours[n].copies[k] && i < b.movable.size(); ++c)
        here[n].add(b.movable.id[i++]);
    ++k;
  });
  for (std::size_t n = 0; n < told.size(); ++n) {
    if (here[n] == told[n]) continue;
    const surplus difference(here[n].count, told[n].count);
    fail<std::runtime_error>(
        "the copies on rank {} are not those that their owner, rank {}, tells of in step {}: {} "
        "instead of {}{}",
        s.link->rank(), s.neighbours[n].rank, s.steps, here[n].count.bodies, told[n].count.bodies,
        difference.single() ? compose(", {} {}", text(s, difference),
                                      difference.bodies < 0 ? "is missing" : "is too much")
                            : std::string(", or others, or in another order"));
  }
}

/// Throws runtime_error if a copy belongs to a body that is owned here, or came from two ranks: the
/// body has two owners.
template <class Scenario>
void require_one_owner(const world_state<Scenario>& s) {
  std::size_t copies = 0;
  s.each_finite_shape([&](const auto& b) { copies += b.movable.size() - b.movable.locals; });
  if (copies == 0) return;
  id_set ids(copies);
  system_id twice = no_id;
  std::size_t shape = 0;
  s.each_finite_shape([&](const auto& b) {
    std::size_t i = b.movable.locals;
    for (const auto& n : s.neighbours)
      for (std::size_t c = 0; c < n.copies[shape] && i < b.movable.size(); ++c, ++i) {
        if constexpr (world_state<Scenario>::periodic)
          if (s.copies.of[shape][i - b.movable.locals].image != 0)
            continue;  // the body itself may be owned here
        if (!ids.insert(b.movable.id[i])) twice = b.movable.id[i];
      }
    ++shape;
  });
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      if (ids.contains(b.movable.id[i])) twice = b.movable.id[i];
  });
  if (twice == no_id) return;
  std::string owners;
  const auto name = [&](int rank) {
    owners += (owners.empty() ? "rank " : " and rank ") + std::to_string(rank);
  };
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    std::size_t i = 0;
    for (; i < b.movable.locals; ++i)
      if (b.movable.id[i] == twice) name(s.link->rank());
    for (const auto& n : s.neighbours)
      for (std::size_t c = 0; c < n.copies[k] && i < b.movable.size(); ++c, ++i)
        if (b.movable.id[i] == twice) name(n.rank);
    ++k;
  });
  fail<std::runtime_error>("body {}{} has two owners in step {}, {}: it is there twice", twice,
                           last_seen(s, twice), s.steps, owners);
}

}  // namespace talus::detail
