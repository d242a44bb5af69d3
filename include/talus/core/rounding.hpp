#pragma once
// Whether a program rounds each operation by itself, as the same bits from every build need.
#include <stdexcept>

#include "talus/core/error.hpp"

namespace talus::detail {

/// False where the compiler may reorder sums, replace quotients or keep more bits than a double
/// has: -ffast-math and its parts, and the registers of the x87.
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    (defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0)
inline constexpr bool rounds_as_written = false;
#else
inline constexpr bool rounds_as_written = true;
#endif

/// Whether this translation unit fuses a product and a sum into one operation. No macro tells, so
/// it is found by numbers that the compiler does not see: fused, the last bit of the square is
/// left.
[[nodiscard]] [[gnu::always_inline]] inline bool fuses_products() {
  const volatile double number = 1 + 0x1p-30, rounded_square = 1 + 0x1p-29;
  const double x = number, y = rounded_square;
  return x * x - y != 0;
}
/// Whether it reorders sums, likewise.
[[nodiscard]] [[gnu::always_inline]] inline bool reorders_sums() {
  const volatile double large = 1, small = 0x1p-60;
  const double x = large, y = small;
  return (x + y) - x != 0;
}

/// Throws runtime_error if products and sums are fused or reordered.
[[gnu::always_inline]] inline void require_rounding_as_written() {
  if (fuses_products() || reorders_sums())
    fail<std::runtime_error>(
        "solver<reproducible> gives the same bits from every build, but this program was compiled "
        "so that products and sums are fused or reordered: add -ffp-contract=off to the options of "
        "the compiler, as CMake does for what links talus::talus, and leave out -ffast-math and "
        "its parts");
}

}  // namespace talus::detail
