#pragma once
// Recursive bisection cuts space in two, and each part again, until there is one for each rank. The
// cuts can move during a run: features<balancing>.
#include <array>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/field_names.hpp"
#include "talus/parallel/bisection_cells.hpp"
#include "talus/parallel/detail/bisect_load.hpp"
#include "talus/parallel/detail/directions.hpp"
#include "talus/parallel/dynamic.hpp"
#include "talus/parallel/grid.hpp"

namespace talus {

/// N boxes made by recursive coordinate bisection (Berger and Bokhari, IEEE Transactions on
/// Computers 36, 1987): a part for n ranks is cut across its longest axis. The n/2 ranks with
/// lower numbers (rounded down) have their share of it below the cut; each side is then divided in
/// the same way. Any number of ranks fits.
///   bisection<7>{.lower = {-3, -3}, .upper = {3, 3}}        equal volumes, cut across x and y
///   bisection<dynamic>{.lower = {...}, .upper = {...}}      as many as there are ranks
///   bisection<3>{.cuts = {{0, -1.5}, {1, 2}}}               cuts where they are given
/// Axes without bounds are never cut. Outermost domains extend to infinity. All ranks hold all
/// cuts: 16 bytes per rank.
template <int N>
struct bisection {
  using talus_fields = detail::fields::bisection_fields;
  static_assert(N >= 1 || N == dynamic,
                "bisection<N> takes the number of ranks, 1 or more, or bisection<dynamic>");
  using bound = grid<1>::bound;

  int count =
      0;  ///< Ranks of bisection<dynamic>; 0: as follows from the cuts, else from the ranks.
  bound lower{};  ///< Where the space to be shared out begins (length), for the axes to be cut.
  bound upper{};  ///< Where it ends (length), above `lower`.
  std::vector<bisection_cut> cuts{};  ///< The first cut, then those below it, then those above.

  /// The number of ranks, 0 while it is open.
  [[nodiscard]] int size() const {
    const int n = detail::chosen_size("bisection", "count", N, count, 0, 1);
    return n == 0 && !cuts.empty() ? static_cast<int>(cuts.size()) + 1 : n;
  }

  /// Throws invalid_argument for another number of ranks, for invalid bounds or cuts, and if both
  /// are missing.
  [[nodiscard, gnu::cold]] bisection_cells resolve(int ranks) const {
    require(ranks);
    if (!cuts.empty() || ranks == 1) return bisection_cells(cuts, ranks);
    std::vector<bisection_cut> equal;
    for (const detail::part_to_cut& p : detail::equal_parts(box(), ranks)) equal.push_back(p.cut);
    return bisection_cells(equal, ranks);
  }

  /// A bisection with its cuts moved so that each rank gets its share of a load. This rank
  /// contributes `places`, each with the weight `weight`. Collective over `link`; all ranks get the
  /// same cuts, which for equal weights do not depend on the rank of each place. The axis of a part
  /// stays until another one is longer by half. Throws invalid_argument without bounds.
  template <class Link>
  [[nodiscard]] bisection shared_out(Link& link, std::span<const vec3> places, std::uint64_t weight,
                                     int ranks) const {
    const detail::cut_bounds bounds = box();
    if (!bounds.open[0] && !bounds.open[1] && !bounds.open[2])
      detail::fail<std::invalid_argument>(
          "the cuts of a bisection are to move, but it has no bounds: give .lower and .upper for "
          "the "
          "axes that may be cut");
    const std::vector<bisection_cut> before = resolve(ranks).cuts();
    bisection moved = *this;
    moved.cuts = detail::load_bisection<Link>(link, places, weight).cuts(bounds, before, ranks);
    return moved;
  }

  /// The positions of the cuts as numbers, for a file.
  [[nodiscard, gnu::cold]] std::vector<real> positions() const {
    std::vector<real> numbers;
    for (const bisection_cut& c : cuts) {
      numbers.push_back(c.axis);
      numbers.push_back(c.at);
    }
    return numbers;
  }
  /// A bisection with its cuts at the given positions, as positions() returns them. Throws
  /// runtime_error for invalid numbers.
  [[nodiscard, gnu::cold]] bisection placed(std::span<const real> positions) const {
    bisection moved = *this;
    moved.cuts.clear();
    for (std::size_t k = 0; k + 1 < positions.size(); k += 2) {
      const real axis = positions[k];
      if (axis != 0 && axis != 1 && axis != 2)
        detail::fail<std::runtime_error>("a cut across axis {} makes no sense", axis);
      moved.cuts.push_back({static_cast<int>(axis), positions[k + 1]});
    }
    return moved;
  }

 private:
  [[gnu::cold]] void require(int ranks) const {
    const int n = size() > 0 ? size() : ranks;
    if (n != ranks)
      detail::fail<std::invalid_argument>(
          "a bisection for {} ranks needs exactly {} ranks, but there are {}: start the program "
          "with "
          "that many, or use bisection<dynamic>, which fits any number",
          n, n, ranks);
    if (cuts.empty() && ranks == 1) return;
    if (cuts.empty() && !(box().open[0] || box().open[1] || box().open[2]))
      detail::fail<std::invalid_argument>(
          "a bisection for {} ranks has no bounds or cuts that say where to cut; give .lower and "
          ".upper for the axes that may be cut, or .cuts",
          ranks);
    if (!cuts.empty() && static_cast<int>(cuts.size()) + 1 != ranks)
      detail::fail<std::invalid_argument>(
          "a bisection for {} ranks needs {} cut(s), but {} are given", ranks, ranks - 1,
          cuts.size());
  }
  [[nodiscard, gnu::cold]] detail::cut_bounds box() const {
    const std::array from{lower.x, lower.y, lower.z}, to{upper.x, upper.y, upper.z};
    detail::cut_bounds result;
    for (std::size_t k = 0; k < 3; ++k) {
      if (from[k] != from[k] && to[k] != to[k]) continue;
      if (!(from[k] < to[k]) || !std::isfinite(to[k] - from[k]))
        detail::fail<std::invalid_argument>(
            "a bisection needs finite bounds along {} with lower < upper, but they are {} and {}; "
            "give .lower and .upper, or none of both for an axis that is not to be cut",
            "xyz"[k], from[k], to[k]);
      result.lower[k] = from[k], result.upper[k] = to[k], result.open[k] = true;
    }
    return result;
  }
};

}  // namespace talus
