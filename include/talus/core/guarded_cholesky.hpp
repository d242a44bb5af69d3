#pragma once
// Small symmetric positive semi-definite systems, whose rows may depend on each other.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "talus/core/math.hpp"

namespace talus::detail {

/// Solves A x = b for some of n <= N rows, by a Cholesky factorization of the lower triangle, with
/// x = 0 elsewhere and in rows that depend on earlier ones.
template <int N>
struct small_system {
  static constexpr auto size = static_cast<std::size_t>(N);
  std::array<std::array<real, size>, size> a{};
  std::array<real, size> b{};

  template <class Used>
  [[nodiscard]] std::array<real, size> solved(Used&& used) const {
    constexpr real least = 1e-13;  // of the diagonal: a pivot that is round-off
    std::array<std::array<real, size>, size> l{};
    std::array<real, size> x{};
    std::array<bool, size> in{};
    for (std::size_t i = 0; i < size; ++i) {
      if (!used(i)) continue;
      real sum = b[i];
      for (std::size_t j = 0; j < i; ++j) {
        if (!in[j]) continue;
        real e = a[i][j];
        for (std::size_t k = 0; k < j; ++k) e -= l[i][k] * l[j][k];
        l[i][j] = e / l[j][j];
        sum -= l[i][j] * x[j];
      }
      real pivot = a[i][i];
      for (std::size_t j = 0; j < i; ++j) pivot -= l[i][j] * l[i][j];
      in[i] = pivot > least * a[i][i];
      if (!in[i]) {
        l[i] = {};
        continue;
      }
      l[i][i] = std::sqrt(pivot);
      x[i] = sum / l[i][i];
    }
    for (std::size_t i = size; i-- > 0;) {
      if (!in[i]) continue;
      real sum = x[i];
      for (std::size_t j = i + 1; j < size; ++j)
        if (in[j]) sum -= l[j][i] * x[j];
      x[i] = sum / l[i][i];
    }
    return x;
  }
};

}  // namespace talus::detail
