#pragma once
// The definitions of colouring.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/solver/colouring.hpp"

namespace talus::detail {

TALUS_INLINE void colouring::start(std::size_t bodies, std::size_t kept) {
  units_.resize(kept);
  sets_.reset(bodies), islands_.reset(bodies);
  units_of_.assign(bodies, 0);
  for (const contact_unit& u : units_) join(u);
  colours_ = 0;
  for (colour_line& l : lines) {
    l.units.clear(), l.out.clear(), l.in.clear();
    l.told = l.heard = l.telling = 0;
  }
}

TALUS_INLINE std::size_t colouring::bytes() const {
  return units_.capacity() * sizeof(contact_unit) + islands_.bytes() +
         units_of_.capacity() * sizeof(std::uint32_t) +
         (order_.capacity() + starts_.capacity() + colour_of_.capacity()) * sizeof(std::uint32_t);
}

TALUS_INLINE bool colouring::comes_before(const contact_unit& x, const contact_unit& y) {
  if (x.priority != y.priority) return x.priority < y.priority;
  if (x.id_a != y.id_a) return value_of(x.id_a) < value_of(y.id_a);
  return x.id_b != y.id_b ? value_of(x.id_b) < value_of(y.id_b) : x.list < y.list;
}

TALUS_INLINE void colouring::sort() {
  const int bits = std::min(16, static_cast<int>(std::bit_width(units_.size())));
  const auto bucket = [&](const contact_unit& u) {
    return static_cast<std::size_t>(u.priority >> (64 - bits));
  };
  starts_.assign((std::size_t{1} << bits) + 1, 0);
  for (const contact_unit& u : units_) ++starts_[bucket(u) + 1];
  for (std::size_t k = 1; k < starts_.size(); ++k) starts_[k] += starts_[k - 1];
  order_.resize(units_.size());
  for (std::size_t n = 0; n < units_.size(); ++n)
    order_[starts_[bucket(units_[n])]++] = static_cast<std::uint32_t>(n);
  for (std::size_t k = 1; k < order_.size(); ++k) {
    const std::uint32_t n = order_[k];
    std::size_t at = k;
    for (; at > 0 && comes_before(units_[n], units_[order_[at - 1]]); --at)
      order_[at] = order_[at - 1];
    order_[at] = n;
  }
}

TALUS_INLINE void colouring::give(std::uint32_t n, std::uint32_t colour) {
  const contact_unit& u = units_[n];
  colour_of_[n] = colour;
  colours_ = std::max(colours_, colour + 1);
  sets_.take(u.a, colour);
  if (u.b >= 0) sets_.take(u.b, colour);
}

TALUS_INLINE std::size_t colouring::colour_sets_size() const {
  std::int32_t most = -1;
  for (const contact_unit& u : units_) most = std::max({most, u.a, u.b});
  return static_cast<std::size_t>(most + 1);
}

TALUS_INLINE void colouring::go_on(std::uint32_t round) {
  std::size_t kept = 0;
  const auto waits = [&](std::int32_t i) -> std::uint32_t& {
    return waits_[static_cast<std::size_t>(i)];
  };
  for (const std::uint32_t n : remaining_) {
    const contact_unit& u = units_[n];
    const bool shared = u.line >= 0;
    const bool ready = waits(u.a) != round && (shared || u.b < 0 || waits(u.b) != round);
    if (ready && !shared) {
      give(n, sets_.lowest_free(u.a, u.b));
      continue;
    }
    if (ready) {
      taken_there& there = there_[number_[n]];
      if (!there.told) tell(lines[static_cast<std::size_t>(u.line)], n);
      there.told = true;
      if (there.known) {
        give(n, sets_.lowest_free(u.a, -1, there.colours));
        continue;
      }
    }
    waits(u.a) = round;
    if (!shared && u.b >= 0) waits(u.b) = round;
    remaining_[kept++] = n;
  }
  remaining_.resize(kept);
}

TALUS_INLINE void colouring::tell(colour_line& l, std::uint32_t n) {
  byte_writer out(l.out);
  const auto at = std::lower_bound(
      l.units.begin(), l.units.end(), n,
      [&](std::uint32_t x, std::uint32_t y) { return comes_before(units_[x], units_[y]); });
  out.put(static_cast<std::uint32_t>(at - l.units.begin()));
  const auto words = sets_.words(units_[n].a);
  out.put(std::span<const std::uint64_t>(words));
  ++l.telling;
}

TALUS_INLINE void colouring::poll(colour_line& l, bool first) {
  byte_reader in(l.in);
  if (first) {
    const auto count = in.get<std::uint64_t>(), sum = in.get<std::uint64_t>();
    std::uint64_t own = 0;
    for (const std::uint32_t n : l.units) own += mix(units_[n].priority);
    if (count != l.units.size() || sum != own)
      fail<std::runtime_error>(
          "two ranks disagree about the pairs of their bodies that touch: {} here, and {} by "
          "rank "
          "{}; a shadow copy is missing or out of date: call synchronize() on all ranks after "
          "changing bodies or connections",
          l.units.size(), count, l.rank);
  }
  for (; !in.empty(); ++l.heard) {
    const auto at = in.get<std::uint32_t>();
    if (at >= l.units.size())
      fail<std::runtime_error>("rank {} told of pair {}, but shares {} with this one", l.rank, at,
                               l.units.size());
    taken_there& there = there_[number_[l.units[at]]];
    const auto words = in.get_all<std::uint64_t>();
    there.colours.assign(words.begin(), words.end());
    there.known = true;
  }
  l.told += std::exchange(l.telling, 0);
  l.out.clear();
}

TALUS_INLINE void colouring::schedule(colour_line& l) {
  l.first.assign(colours_ + 1, 0);
  for (const std::uint32_t n : l.units) ++l.first[colour_of_[n] + 1];
  for (std::size_t k = 1; k < l.first.size(); ++k) l.first[k] += l.first[k - 1];
  l.own.resize(l.units.size()), l.foreign.resize(l.units.size());
  plain_vector<std::uint32_t> next = l.first;
  for (const std::uint32_t n : l.units) {
    const std::uint32_t at = next[colour_of_[n]]++;
    l.own[at] = units_[n].a, l.foreign[at] = units_[n].b;
  }
}

}  // namespace talus::detail
