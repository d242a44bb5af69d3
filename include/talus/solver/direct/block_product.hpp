#pragma once
// Products of small dense blocks, compiled for the sizes that bodies and joints have.
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Subtracts sign X Y' from a block, where X has `rows` rows and `inner` columns, and `turned` is
/// the transpose of Y, with `columns` columns. Each sum has the same order for all sizes.
using block_product = void (*)(real* to, const real* x, const real* turned, std::size_t rows,
                               std::size_t inner, std::size_t columns, real sign);

/// Subtracts sign X Y' from a block, for matrices of any sizes.
inline void subtract_product(real* to, const real* x, const real* turned, std::size_t rows,
                             std::size_t inner, std::size_t columns, real sign) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      real sum = 0;
      for (std::size_t k = 0; k < inner; ++k) sum += x[i * inner + k] * turned[k * columns + j];
      to[i * columns + j] -= sign * sum;
    }
}
/// Subtracts sign X Y' from a block, for sizes known at compile time: a row of sums stays in
/// registers.
template <std::size_t Inner, std::size_t Columns>
void subtract_product_of(real* to, const real* x, const real* turned, std::size_t rows, std::size_t,
                         std::size_t, real sign) {
  for (std::size_t i = 0; i < rows; ++i) {
    std::array<real, Columns> sum{};
    for (std::size_t k = 0; k < Inner; ++k)
      for (std::size_t j = 0; j < Columns; ++j)
        sum[j] += x[i * Inner + k] * turned[k * Columns + j];
    for (std::size_t j = 0; j < Columns; ++j) to[i * Columns + j] -= sign * sum[j];
  }
}

template <std::size_t Inner>
[[nodiscard]] block_product block_product_with(std::size_t columns) {
  if (columns == 3) return subtract_product_of<Inner, 3>;
  if (columns == 6) return subtract_product_of<Inner, 6>;
  if (columns == 9) return subtract_product_of<Inner, 9>;
  return subtract_product;
}
/// The sizes of bodies (6), ball joints (3) and hinges (9) have code of their own.
[[nodiscard]] inline block_product block_product_of(std::size_t inner, std::size_t columns) {
  if (inner == 3) return block_product_with<3>(columns);
  if (inner == 6) return block_product_with<6>(columns);
  if (inner == 9) return block_product_with<9>(columns);
  return subtract_product;
}

}  // namespace talus::detail
