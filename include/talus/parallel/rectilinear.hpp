#pragma once
// Cells between given cuts: a grid given by its cuts alone.
#include "talus/core/field_names.hpp"
#include "talus/parallel/grid.hpp"

namespace talus {

/// The cells of grid<X, Y, Z>{.cuts = {x, y, z}}; rank = ix + X (iy + Y iz). An axis without cuts
/// has one cell.
///   rectilinear<3, 2>{.x = {-1, 4}, .y = {0}}     6 ranks
///   rectilinear<>{.x = {-1, 4}, .z = {0}}         as many as the cuts make
template <int X = dynamic, int Y = X == dynamic ? dynamic : 1, int Z = X == dynamic ? dynamic : 1>
struct rectilinear {
  using talus_fields = detail::fields::rectilinear_fields;
  std::vector<real> x{};  ///< Positions of the cuts across x (length), strictly increasing.
  std::vector<real> y{};  ///< Positions of the cuts across y (length), strictly increasing.
  std::vector<real> z{};  ///< Positions of the cuts across z (length), strictly increasing.

  /// The number of ranks, 0 while no cuts are given.
  [[nodiscard]] int size() const {
    const bool given = !(x.empty() && y.empty() && z.empty());
    return given || X * Y * Z > 0 ? as_grid().size() : 0;
  }
  /// Throws the errors of grid.
  [[nodiscard]] grid_cells resolve(int ranks) const { return as_grid().resolve(ranks); }

  [[nodiscard]] grid<X, Y, Z> as_grid() const {
    const auto cells = [](int given, const std::vector<real>& cuts) {
      return given == dynamic ? static_cast<int>(cuts.size()) + 1 : given;
    };
    return {.cells = {cells(X, x), cells(Y, y), cells(Z, z)},
            .lower = {},
            .upper = {},
            .cuts = {x, y, z}};
  }
};

}  // namespace talus
