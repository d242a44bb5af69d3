#pragma once
// Cells of a grid parallel to the axes: the decomposition for most scenes.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "talus/core/error.hpp"
#include "talus/core/field_names.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/geometry/any_geometry.hpp"
#include "talus/parallel/dynamic.hpp"

namespace talus {

/// The cells of a grid with known cuts. Cells are half-open: a point on a cut belongs to the upper
/// cell. Cells at the border extend to infinity.
class grid_cells {
 public:
  using cuts_type = std::array<std::vector<real>, 3>;

  /// Strictly increasing positions of the cuts along each axis.
  explicit grid_cells(cuts_type cuts);

  [[nodiscard]] int size() const { return n_[0] * n_[1] * n_[2]; }
  /// Number of cells along each axis.
  [[nodiscard]] const std::array<int, 3>& cells() const { return n_; }
  [[nodiscard]] const cuts_type& cuts() const { return cuts_; }

  [[nodiscard]] int owner(const vec3& p) const;

  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const;

  [[nodiscard]] any_geometry geometry(int rank) const;

  /// The bounds of one cell, for queries of every body in every step.
  struct cell_bounds {
    std::array<real, 3> lower, upper;

    [[nodiscard]] bool contains(const vec3& p) const {
      const auto inside = [&](int i) {
        const real x = p[i], from = lower[i], to = upper[i];
        return (x >= from) & (x < to);
      };
      const bool x = inside(0), y = inside(1), z = inside(2);
      return x & y & z;  // all at once, without branches
    }
    /// Distance to the nearest other cell; negative outside.
    [[nodiscard]] real interior_distance(const vec3& p) const {
      const auto gap = [&](int i) { return std::min(p[i] - lower[i], upper[i] - p[i]); };
      return std::min(gap(0), std::min(gap(1), gap(2)));
    }
  };
  [[nodiscard]] cell_bounds cell(int rank) const;

 private:
  [[nodiscard]] int index(int axis, real x) const;
  [[nodiscard]] std::array<int, 3> position(int rank) const;
  [[nodiscard]] real lower(int axis, int i) const;
  [[nodiscard]] real upper(int axis, int i) const;

  cuts_type cuts_;
  std::array<int, 3> n_;
};

namespace detail {

inline constexpr int unsaid = -2;

/// Replaces the zeros of `cells` so that their product is `ranks`, with factors as equal as
/// possible, larger ones first. Returns false if `ranks` is not a multiple of the given numbers.
bool balance(std::array<int, 3>& cells, int ranks);

}  // namespace detail

/// X by Y by Z cells; rank = ix + X (iy + Y iz). `grid<dynamic>` takes any number of cells in three
/// dimensions, `grid<dynamic, dynamic>` in two, `grid<dynamic, 1, 1>` in one.
///   grid<2, 2>{.lower = {-30, -30}, .upper = {30, 30}}   equal cells in between
///   grid<2, 3>{.cuts = {{0}, {-1, 1}}}                   cuts where they are given
///   grid<dynamic>{.cells = {4, 2, 1}, ...}               extents when the program runs
/// The cells at the border extend to infinity. Two cells along an axis without bounds or cuts are
/// cut at 0.
template <int X, int Y = detail::unsaid, int Z = detail::unsaid>
struct grid {
  using talus_fields = detail::fields::grid_fields;
  struct bound {
    static constexpr real unset = std::numeric_limits<real>::quiet_NaN();
    real x = unset, y = unset, z = unset;
  };
  struct cut_lists {
    std::vector<real> x{}, y{}, z{};
  };

  /// Cells along each axis where the type says dynamic; 0: as follows from the cuts, else from the
  /// number of ranks, shared out evenly (larger factors in x).
  std::array<int, 3> cells{};
  bound lower{};     ///< Where equal cells begin (length).
  bound upper{};     ///< Where they end (length), above `lower`.
  cut_lists cuts{};  ///< Positions of the cuts (length), strictly increasing, instead of bounds.

  /// The number of ranks, 0 while it is open.
  [[nodiscard]] int size() const {
    const auto n = known();
    return n[0] * n[1] * n[2];
  }

  [[nodiscard, gnu::cold]] grid_cells resolve(int ranks) const {
    auto n = known();
    const std::array<int, 3> asked = n;
    if (!detail::balance(n, ranks)) {
      const auto show = [](int i) { return i == 0 ? std::string("?") : std::to_string(i); };
      detail::fail<std::invalid_argument>(
          "a grid of {} x {} x {} cells needs {} {} ranks, but there are {}: "
          "start the program with that many, or use grid<dynamic>, which fits any number",
          show(asked[0]), show(asked[1]), show(asked[2]), size() > 0 ? "exactly" : "a multiple of",
          std::max(asked[0], 1) * std::max(asked[1], 1) * std::max(asked[2], 1), ranks);
    }
    return grid_cells({axis(0, n[0], lower.x, upper.x, cuts.x),
                       axis(1, n[1], lower.y, upper.y, cuts.y),
                       axis(2, n[2], lower.z, upper.z, cuts.z)});
  }

 private:
  static constexpr bool all_open_ = X == dynamic && Y == detail::unsaid && Z == detail::unsaid;
  static constexpr std::array<int, 3> given_{X,
                                             Y != detail::unsaid ? Y
                                             : all_open_         ? dynamic
                                                                 : 1,
                                             Z != detail::unsaid ? Z
                                             : all_open_         ? dynamic
                                                                 : 1};
  static_assert((given_[0] > 0 || given_[0] == dynamic) &&
                    (given_[1] > 0 || given_[1] == dynamic) &&
                    (given_[2] > 0 || given_[2] == dynamic),
                "a grid has at least one cell along each axis: write grid<2, 3> or grid<dynamic>");

  /// Cells along each axis as the type, `cells` or the cuts say; 0 where that is left open.
  [[nodiscard, gnu::cold]] std::array<int, 3> known() const {
    std::array<int, 3> n{};
    const std::array<const std::vector<real>*, 3> lists{&cuts.x, &cuts.y, &cuts.z};
    for (int i = 0; i < 3; ++i) {
      const char name = "xyz"[i];
      if (cells[i] < 0)
        detail::fail<std::invalid_argument>(
            "a grid has at least one cell along {}, but .cells says {}; use 0 to leave it open",
            name, cells[i]);
      if (given_[i] != dynamic && cells[i] != 0 && cells[i] != given_[i])
        detail::fail<std::invalid_argument>(
            "the type of the grid says {} cell(s) along {}, but .cells says {}; "
            "write dynamic in the type to choose at run time",
            given_[i], name, cells[i]);
      n[i] = given_[i] != dynamic ? given_[i] : cells[i];
      if (n[i] == 0 && !lists[i]->empty()) n[i] = static_cast<int>(lists[i]->size()) + 1;
    }
    return n;
  }

  [[gnu::cold]] static std::vector<real> axis(int i, int n, real from, real to,
                                              const std::vector<real>& given) {
    const char name = "xyz"[i];
    const bool bounds = from == from || to == to;
    std::vector<real> result = given;
    if (!given.empty()) {
      if (bounds)
        detail::fail<std::invalid_argument>(
            "the grid has both bounds and cuts along {}; give one of the two", name);
      if (static_cast<int>(given.size()) + 1 != n)
        detail::fail<std::invalid_argument>(
            "{} cells along {} need {} cut(s), but {} are given; cuts lie between cells, "
            "and the cells at the border extend to infinity",
            n, name, n - 1, given.size());
    } else if (n > 1 && bounds) {
      if (!(from < to) || !std::isfinite(to - from))
        detail::fail<std::invalid_argument>(
            "the grid needs finite bounds along {} with lower < upper, but they are {} and {}; "
            "give .lower and .upper",
            name, from, to);
      // Once, from the same three numbers on every rank: both sides of a cut see the same bits.
      for (int k = 1; k < n; ++k) result.push_back(from + (to - from) * k / n);
    } else if (n == 2) {
      result.push_back(0);
    } else if (n > 2) {
      detail::fail<std::invalid_argument>(
          "the grid has {} cells along {}, but no bounds or cuts there say where to cut; "
          "give .lower and .upper (equal cells in between) or .cuts",
          n, name);
    }
    for (real& cut : result) cut += 0.0;  // -0 becomes 0
    for (std::size_t k = 0; k < result.size(); ++k)
      if (!std::isfinite(result[k]) || (k > 0 && !(result[k - 1] < result[k])))
        detail::fail<std::invalid_argument>(
            "the cuts of the grid along {} must be finite and strictly increasing, but cut {} is "
            "{}{}; sort them and remove repetitions",
            name, k, result[k],
            k > 0 ? detail::compose(" after {}", result[k - 1]) : std::string());
    return result;
  }
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/grid_definitions.hpp"
#endif
