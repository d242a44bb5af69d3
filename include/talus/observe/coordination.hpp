#pragma once
// The number of neighbours that bodies touch.
#include <array>
#include <cstdint>
#include <span>

#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The coordination number of the bodies that can move. Two bodies are neighbours if a contact
/// between them carries a force, with any number of points.
struct coordination {
  double mean = 0;              ///< neighbours of a body, fixed and global ones among them
  double mean_of_touching = 0;  ///< the same without the bodies without contacts
  std::uint64_t bodies = 0;     ///< that can move
  std::uint64_t alone = 0;      ///< of them, those without contacts
};

namespace detail {

struct touch {
  system_id body, neighbour;
  friend bool operator==(const touch&, const touch&) = default;
  friend bool operator<(const touch& x, const touch& y) {
    return x.body != y.body ? x.body < y.body : x.neighbour < y.neighbour;
  }
};

}  // namespace detail

/// Collective: the coordination number of the present state. Costs one pass over the contacts, and
/// nothing if it is not called. Zero before the first step.
template <class Scenario>
[[nodiscard]] coordination measure_coordination(world<Scenario>& w) {
  w.require_all_ranks("measure_coordination");
  detail::plain_vector<detail::touch> touches;
  detail::each_loaded_contact(detail::state_of(w), [&](const loaded_contact& c, bool) {
    if (c.owned_a && c.moves_a) touches.push_back({c.a, c.b});
    if (c.owned_b && c.moves_b) touches.push_back({c.b, c.a});
  });
  detail::sort_values(touches);
  std::array<std::uint64_t, 3> sums{};  // neighbours, bodies that touch, bodies
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const bool first = i == 0;
    if (first || !(touches[i] == touches[i - 1])) ++sums[0];
    if (first || touches[i].body != touches[i - 1].body) ++sums[1];
  }
  w.for_each_local([&](const auto& b) { sums[2] += !b.is_fixed(); });
  w.link().reduce(reduction::sum, std::span<std::uint64_t>(sums));
  coordination c;
  c.bodies = sums[2];
  c.alone = sums[2] - sums[1];
  const auto neighbours = static_cast<double>(sums[0]);
  if (sums[2] > 0) c.mean = neighbours / static_cast<double>(sums[2]);
  if (sums[1] > 0) c.mean_of_touching = neighbours / static_cast<double>(sums[1]);
  return c;
}

}  // namespace talus
