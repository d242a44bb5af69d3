#pragma once
// Bodies that start inside each other, or inside a wall: the most common mistake in a scenario.
#include <span>
#include <string>

#include "talus/core/error.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// The initial overlap of a pair, over half the thickness of the thinner body, up to which there is
/// no warning.
inline constexpr double deepest_start = 0.1;

/// Collective: the warning about the pair with the largest overlap, on one of the ranks that know
/// it, and nothing on all others. Needs up-to-date shadow copies.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string initial_overlap(world<Scenario>& w) {
  const deepest_pair worst = measure_gaps(view_of(w), mean_radius(w)).worst;
  double most = worst.part;
  w.link().reduce(reduction::max, std::span(&most, 1));
  if (!(most > deepest_start)) return {};
  double first = worst.part == most ? -w.rank() : -w.ranks();
  w.link().reduce(reduction::max, std::span(&first, 1));
  if (first != -w.rank()) return {};
  const std::string which =
      worst.normal.squaredNorm() > 0 ? compose(" with the normal {}", worst.normal) : std::string();
  return compose(
      "the {} {} at {} begins {} deep in the {} {}{}, {} of half the thickness of the thinner one: "
      "contacts will push them apart, perhaps fast; leave room between bodies at the start",
      worst.shape_a, worst.a, worst.at, text(worst.depth, 3), worst.shape_b, worst.b, which,
      text(worst.part, 2));
}

}  // namespace talus::detail
