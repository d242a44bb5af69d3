#pragma once
// Slabs one behind the other along any direction.
#include <algorithm>
#include <string>
#include <vector>

#include "talus/core/field_names.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/parallel/detail/convex_pieces.hpp"
#include "talus/parallel/detail/directions.hpp"
#include "talus/parallel/dynamic.hpp"

namespace talus {

/// Slabs between parallel cuts. A point on a cut belongs to the side towards +x (then +y, +z),
/// which is the upper slab for directions along the axes.
class slab_cells {
 public:
  /// Strictly increasing positions of the cuts along a unit vector.
  slab_cells(const vec3& direction, std::vector<real> cuts)
      : towards_(direction, 0.0), cuts_(std::move(cuts)) {}

  [[nodiscard]] int size() const { return static_cast<int>(cuts_.size()) + 1; }
  [[nodiscard]] const std::vector<real>& cuts() const { return cuts_; }

  [[nodiscard]] int owner(const vec3& p) const;
  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const;
  [[nodiscard]] any_geometry geometry(int rank) const { return any_geometry::cell(planes(rank)); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const;

 private:
  void require(int rank) const;
  [[nodiscard]] real upper(int slab) const { return cuts_[static_cast<std::size_t>(slab)]; }
  [[nodiscard]] detail::plain_vector<half_space> planes(int rank) const;

  half_space towards_;
  std::vector<real> cuts_;
};

/// N slabs along an axis; rank 0 is the lowest along it. The first and the last one extend to
/// infinity.
///   slabs<5>{.lower = 0, .upper = 10}                                equal slabs in between
///   slabs<3>{.axis = {0, 0, 1}, .cuts = {-1, 4}}                     cuts where they are given
///   slabs<dynamic>{.lower = 0, .upper = 10}                          as many as there are ranks
/// Two slabs without bounds or cuts are cut at 0.
template <int N>
struct slabs {
  using talus_fields = detail::fields::slabs_fields;
  static_assert(N >= 1 || N == dynamic,
                "slabs<N> takes the number of slabs, 1 or more, or slabs<dynamic>");
  static constexpr real unset = std::numeric_limits<real>::quiet_NaN();

  int count = 0;  ///< Slabs of slabs<dynamic>; 0: as follows from the cuts, else from the ranks.
  vec3 axis{1, 0, 0};        ///< Across the slabs; any length but zero.
  real lower = unset;        ///< Where equal slabs begin, along the axis from the origin (length).
  real upper = unset;        ///< Where they end (length), above `lower`.
  std::vector<real> cuts{};  ///< Positions of the cuts (length), increasing, instead of bounds.

  /// The number of ranks, 0 while it is open.
  [[nodiscard]] int size() const {
    const int n = detail::chosen_size("slabs", "count", N, count, 0, 1);
    return n == 0 && !cuts.empty() ? static_cast<int>(cuts.size()) + 1 : n;
  }

  [[nodiscard]] slab_cells resolve(int ranks) const {
    const int n = size() > 0 ? size() : ranks;
    if (n != ranks)
      detail::fail<std::invalid_argument>(
          "{} slabs need exactly {} ranks, but there are {}: start the program with that many, or "
          "use slabs<dynamic>, which fits any number",
          n, n, ranks);
    return {detail::axis_frame::direction("slabs", "axis", axis), positions(n)};
  }

 private:
  [[nodiscard]] std::vector<real> positions(int n) const {
    const bool bounds = lower == lower || upper == upper;
    std::vector<real> result = cuts;
    if (!cuts.empty()) {
      if (bounds)
        detail::fail<std::invalid_argument>(
            "the slabs have both bounds and cuts; give one of the two");
      if (static_cast<int>(cuts.size()) + 1 != n)
        detail::fail<std::invalid_argument>(
            "{} slabs need {} cut(s), but {} are given; the first and the last slab extend to "
            "infinity",
            n, n - 1, cuts.size());
    } else if (n > 1 && bounds) {
      if (!(lower < upper) || !std::isfinite(upper - lower))
        detail::fail<std::invalid_argument>(
            "the slabs need finite bounds with lower < upper, but they are {} and {}; give .lower "
            "and .upper",
            lower, upper);
      for (int k = 1; k < n; ++k) result.push_back(lower + (upper - lower) * k / n);
    } else if (n == 2) {
      result.push_back(0);
    } else if (n > 2) {
      detail::fail<std::invalid_argument>(
          "{} slabs have no bounds or cuts that say where to cut; give .lower and .upper (equal "
          "slabs in between) or .cuts",
          n);
    }
    for (real& cut : result) cut += 0.0;  // -0 becomes 0
    for (std::size_t k = 0; k < result.size(); ++k)
      if (!std::isfinite(result[k]) || (k > 0 && !(result[k - 1] < result[k])))
        detail::fail<std::invalid_argument>(
            "the cuts of the slabs must be finite and strictly increasing, but cut {} is {}{}; "
            "sort "
            "them and remove repetitions",
            k, result[k], k > 0 ? detail::compose(" after {}", result[k - 1]) : std::string());
    return result;
  }
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/slabs_definitions.hpp"
#endif
