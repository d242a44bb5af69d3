#pragma once
// Sums over ranks whose bits do not depend on the distribution of the terms.
#include <array>
#include <cstddef>
#include <span>

#include "talus/core/exact_sum.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus::detail {

/// Calls f(exact_sum&) for each of which a sum consists.
template <class F>
void each_exact_sum(exact_sum& x, F&& f) {
  f(x);
}
template <class F>
void each_exact_sum(signed_sum& x, F&& f) {
  f(x.plus), f(x.minus);
}
template <class F>
void each_exact_sum(vector_sum& x, F&& f) {
  for (signed_sum& part : x.parts) each_exact_sum(part, f);
}
template <class Sum, std::size_t N, class F>
void each_exact_sum(std::array<Sum, N>& all, F&& f) {
  for (Sum& x : all) each_exact_sum(x, f);
}

/// Collective: replaces sums (exact_sum, signed_sum, vector_sum, arrays of them) by those over all
/// ranks, in one reduction.
template <class Link, class... Sums>
void sum_exactly(Link& link, Sums&... sums) {
  constexpr std::size_t size = exact_sum::digits + 1;
  constexpr std::size_t count = (sizeof(Sums) + ...) / sizeof(exact_sum);
  std::array<double, count * size> digits;
  const auto each = [&](auto&& f) {
    double* at = digits.data();
    const auto next = [&](exact_sum& x) {
      f(x, std::span<double, size>(at, size));
      at += size;
    };
    (each_exact_sum(sums, next), ...);
  };
  each([](exact_sum& x, std::span<double, size> to) { x.write(to); });
  link.reduce(reduction::sum, std::span<double>(digits));
  each([](exact_sum& x, std::span<double, size> from) { x.read(from); });
}

}  // namespace talus::detail
