#pragma once
// The definitions of dependence_cones.hpp, in the compiled part or in each program.
#include <algorithm>

#include "talus/core/linkage.hpp"
#include "talus/solver/dependence_cones.hpp"

namespace talus::detail {

TALUS_INLINE void dependence_cones::start(int rank, std::size_t bodies, std::size_t neighbours) {
  rank_ = rank;
  bodies_ = bodies;
  owner_.assign(bodies, rank);
  known_.assign(bodies, 0);
  slot_.assign(bodies, 0);
  cells_.clear();
  for (auto& units : by_colour_) units.clear();
  added_.clear();
  from_others_.clear(), numbers_.clear();
  lines.resize(neighbours);
  for (line& l : lines) {
    l.open = l.more = false;
    l.told = 0;
    l.sent.clear(), l.received.clear(), l.before.clear(), l.raised.clear(), l.third.clear();
  }
}

TALUS_INLINE void dependence_cones::add(const known_unit& unit, std::uint32_t colour) {
  if (by_colour_.size() <= colour) by_colour_.resize(colour + 1);
  by_colour_[colour].push_back(unit);
}

TALUS_INLINE void dependence_cones::add_body(std::int32_t body, system_id name, int owner) {
  owner_.push_back(owner);
  known_.push_back(0), slot_.push_back(0);
  added_.push_back(name);
  set_name(name, body);
}

TALUS_INLINE void dependence_cones::raise_known(std::int32_t body, std::uint32_t level) {
  known_[at(body)] = std::max(known_[at(body)], level);
}

TALUS_INLINE std::size_t dependence_cones::cells_of(std::int32_t body) {
  std::uint32_t& slot = slot_[at(body)];
  if (slot == 0) {
    cells_.resize(cells_.size() + lines.size());
    slot = static_cast<std::uint32_t>(cells_.size() / lines.size());
  }
  return (slot - 1) * lines.size();
}

TALUS_INLINE std::uint32_t dependence_cones::index_in_table(std::size_t n, std::int32_t body) {
  cell& c = cells_[cells_of(body) + n];
  if (c.index == none) {
    c.index = static_cast<std::uint32_t>(lines[n].sent.size());
    lines[n].sent.push_back(body);
  }
  return c.index;
}

TALUS_INLINE void dependence_cones::raise(std::size_t n, std::int32_t body, std::uint32_t need) {
  cell& c = cells_[cells_of(body) + n];
  if (c.need >= need) return;
  line& l = lines[n];
  const int owner = owner_[at(body)];
  if (c.need == 0 && owner != rank_ && owner != l.rank) l.third.push_back(body);
  c.need = need;
  l.raised.push_back(body);
}

TALUS_INLINE void dependence_cones::add_to_cone(std::size_t n, std::uint32_t colour,
                                                std::uint32_t index) {
  const known_unit& u = by_colour_[colour][index];
  const std::uint32_t level = colour + 1;
  const auto need = [&](std::int32_t body) {
    return body < 0 || slot_[at(body)] == 0 ? 0 : cells_[cells_of(body) + n].need;
  };
  if (need(u.a) <= level && need(u.b) <= level) return;
  raise(n, u.a, level);
  if (u.b >= 0) raise(n, u.b, level);
  if (lines[n].before.insert(key(index, colour)).second) lines[n].units.push_back({colour, index});
}

TALUS_INLINE void dependence_cones::find(bool first) {
  for (line& l : lines) l.units.clear(), l.levels.clear(), l.raised.clear(), l.more = false;
  for (std::size_t c = by_colour_.size(); c-- > 0;) {
    const auto colour = static_cast<std::uint32_t>(c);
    for (std::uint32_t k = 0; k < by_colour_[c].size(); ++k) {
      const known_unit& u = by_colour_[c][k];
      const int owner_a = owner_[at(u.a)], owner_b = u.b < 0 ? owner_a : owner_[at(u.b)];
      if (slot_[at(u.a)] != 0 || (u.b >= 0 && slot_[at(u.b)] != 0))
        for (std::size_t n = 0; n < lines.size(); ++n)
          // A rank has all contacts of its own bodies.
          if (lines[n].open && owner_a != lines[n].rank && owner_b != lines[n].rank)
            add_to_cone(n, colour, k);
      if (first && owner_a == rank_ && owner_b != rank_)
        for (std::size_t n = 0; n < lines.size(); ++n)
          if (lines[n].rank == owner_b) raise(n, u.a, colour + 1);
    }
  }
  for (std::size_t n = 0; n < lines.size(); ++n)
    if (lines[n].open) find_levels(n);
}

TALUS_INLINE void dependence_cones::find_levels(std::size_t n) {
  line& l = lines[n];
  for (const std::int32_t body : l.raised) find_level(n, body);
  for (const std::int32_t body : l.third) {
    find_level(n, body);
    l.more = l.more || known_[at(body)] < cells_[cells_of(body) + n].need;
  }
}

TALUS_INLINE void dependence_cones::find_level(std::size_t n, std::int32_t body) {
  const std::uint32_t index = index_in_table(n, body);
  cell& c = cells_[cells_of(body) + n];
  std::uint32_t level = c.need;
  if (owner_[at(body)] != rank_) level = std::min(level, known_[at(body)]);
  if (level == c.told) return;
  c.told = level;
  lines[n].levels.push_back({index, level});
}

TALUS_INLINE std::size_t dependence_cones::bytes() const {
  std::size_t sum = owner_.capacity() * sizeof(int) + cells_.capacity() * sizeof(cell) +
                    (known_.capacity() + slot_.capacity()) * sizeof(std::uint32_t);
  for (const auto& units : by_colour_) sum += units.capacity() * sizeof(known_unit);
  return sum;
}

}  // namespace talus::detail
