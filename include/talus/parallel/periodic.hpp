#pragma once
// A grid with periodic sides: bodies that leave on one side enter on the other.
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/parallel/grid.hpp"
#include "talus/parallel/periodic_box.hpp"
#include "talus/parallel/policy.hpp"

namespace talus {

/// A periodic axis.
enum class along { x, y, z };

/// The cells of a periodic grid. Along a periodic axis they fill the box from its lower side up to
/// its upper one, which belongs to its images. Along other axes the cells at the border extend to
/// infinity.
class periodic_cells {
 public:
  periodic_cells(grid_cells cells, const periodic_box& box) : cells_(std::move(cells)), box_(box) {}

  [[nodiscard]] int size() const { return cells_.size(); }
  [[nodiscard]] const periodic_box& box() const { return box_; }

  /// The rank that owns the image of a point in the box.
  [[nodiscard]] int owner(const vec3& p) const { return cells_.owner(box_.wrapped(p)); }

  /// Ranks with an image of their cell within `reach`; the rank itself is one if it is next to an
  /// image of its own.
  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const {
    const auto& n = cells_.cells();
    const std::array<int, 3> at{rank % n[0], rank / n[0] % n[1], rank / n[0] / n[1]};
    const auto own = cell(rank);
    std::array<std::vector<int>, 3> near;
    bool own_image = false;
    for (int k = 0, step = 1; k < 3; step *= n[k], ++k)
      for (int i = 0; i < n[k]; ++i) {
        const auto other = cell(rank + (i - at[k]) * step);
        real gap = std::max(other.lower[k] - own.upper[k], own.lower[k] - other.upper[k]);
        const real period = box_.period()[k];
        if (period > 0) {
          // The first and the last cell touch, also after round-off.
          const real around = std::abs(i - at[k]) == n[k] - 1
                                  ? 0
                                  : std::min(other.lower[k] + period - own.upper[k],
                                             own.lower[k] + period - other.upper[k]);
          if (i == at[k])
            own_image = own_image || around <= reach;
          else
            gap = std::min(gap, around);
        }
        if (i == at[k] || gap <= reach) near[k].push_back(i);
      }
    std::vector<int> ranks;
    for (const int z : near[2])
      for (const int y : near[1])
        for (const int x : near[0])
          if (const int other = x + n[0] * (y + n[1] * z); other != rank || own_image)
            ranks.push_back(other);
    return ranks;
  }

  [[nodiscard]] any_geometry geometry(int rank) const {
    const auto own = cell(rank);
    detail::plain_vector<half_space> planes;
    for (int k = 0; k < 3; ++k) {
      const vec3 normal = vec3::Unit(k);
      if (std::isfinite(own.lower[k])) planes.push_back({normal, own.lower[k]});
      if (std::isfinite(own.upper[k])) planes.push_back(half_space(normal, own.upper[k]).flipped());
    }
    return any_geometry::cell(planes);
  }

  [[nodiscard]] grid_cells::cell_bounds cell(int rank) const {
    auto bounds = cells_.cell(rank);
    for (int k = 0; k < 3; ++k)
      if (box_.period()[k] > 0) {
        bounds.lower[k] = std::max(bounds.lower[k], box_.lower()[k]);
        bounds.upper[k] = std::min(bounds.upper[k], box_.upper()[k]);
      }
    return bounds;
  }

 private:
  grid_cells cells_;
  periodic_box box_;
};

/// A grid with periodic axes, of any number of ranks, one included:
///   periodic<grid<dynamic>, along::x, along::y>{{.lower = {0, 0}, .upper = {8, 4}}}
/// The bounds of the grid along these axes are the periodic sides of the box; its cells are equal
/// along them. A rank that reaches from side to side is its own neighbour.
template <class Grid, along... Axes>
struct periodic {
  static_assert(sizeof...(Axes) > 0,
                "periodic<...> takes a grid and the axes that are periodic: write "
                "periodic<grid<dynamic>, along::x>");
  static_assert(
      requires(const Grid& g) {
        g.lower.x, g.upper.z;
        { g.resolve(1) } -> std::same_as<grid_cells>;
      },
      "periodic<...> joins the sides of a box, so it takes a grid: write "
      "periodic<grid<dynamic>, along::x>");

  Grid cells{};

  [[nodiscard]] int size() const { return cells.size(); }

  [[nodiscard, gnu::cold]] periodic_cells resolve(int ranks) const {
    const std::array<real, 3> lower{cells.lower.x, cells.lower.y, cells.lower.z};
    const std::array<real, 3> upper{cells.upper.x, cells.upper.y, cells.upper.z};
    for (const auto a : {Axes...}) {
      const auto k = static_cast<std::size_t>(a);
      if (!(lower[k] < upper[k]) || !std::isfinite(upper[k] - lower[k]))
        detail::fail<std::invalid_argument>(
            "space is periodic along {}, but the sides of the box there are {} and {}: give the "
            "grid finite .lower and .upper, with lower < upper",
            "xyz"[k], lower[k], upper[k]);
    }
    vec3 low{0, 0, 0}, high{0, 0, 0};
    ((low[static_cast<int>(Axes)] = lower[static_cast<std::size_t>(Axes)],
      high[static_cast<int>(Axes)] = upper[static_cast<std::size_t>(Axes)]),
     ...);
    return {cells.resolve(ranks), periodic_box(low, high)};
  }
};

namespace detail {
template <class Grid, along... Axes>
inline constexpr bool is_periodic<periodic<Grid, Axes...>> = true;
}

}  // namespace talus
