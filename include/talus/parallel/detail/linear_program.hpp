#pragma once
// Linear programs in up to four unknowns, which determine the contact and extent of regions bounded
// by planes. For the set-up, not for steps.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Unknowns and their coefficients; those beyond the dimension are ignored.
using lp_vector = std::array<real, 4>;

/// a·x >= b.
struct lp_bound {
  lp_vector a{};
  real b = 0;
};

/// Numbers in a linear program are of the order of 1; larger numbers than this count as infinite.
inline constexpr real lp_far = 1e4;
inline constexpr real lp_rounding = 1e-13;

/// The point that maximises c·x under all bounds and |x_k| <= lp_far, by adding one bound after the
/// other (Seidel 1991); nothing if no point fulfils all. If c leaves x undetermined, x stays
/// small.
std::optional<lp_vector> maximize(int dimension, const plain_vector<lp_bound>& bounds,
                                  const lp_vector& c);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/linear_program_definitions.hpp"
#endif
