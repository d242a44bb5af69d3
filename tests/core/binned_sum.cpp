#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <talus/core/binned_sum.hpp>
#include <vector>

using talus::detail::binned_sum;
using talus::detail::signed_sum;

namespace {

binned_sum sum_of(const std::vector<double>& terms) {
  binned_sum s;
  for (const double x : terms) s += x;
  return s;
}

}  // namespace

TEST_CASE("a binned sum is the same in any order and grouping, for terms of all sizes") {
  std::mt19937_64 random(20261126);
  for (const unsigned range : {1u, 40u, 300u, 2000u})
    for (int run = 0; run < 200; ++run) {
      CAPTURE(range);
      CAPTURE(run);
      std::vector<double> terms(1 + random() % 300);
      for (double& x : terms)
        x = std::ldexp(static_cast<double>(random() >> 11) - 0x1p52,
                       500 - static_cast<int>(random() % range));
      const double first = sum_of(terms).value();
      std::shuffle(terms.begin(), terms.end(), random);
      CHECK(sum_of(terms).value() == first);
      binned_sum all;
      for (std::size_t k = 0; k < 3; ++k) {
        binned_sum s;
        for (std::size_t i = k; i < terms.size(); i += 3) s += terms[i];
        all += s;
      }
      CHECK(all.value() == first);
      // It is the exact one beside the largest term.
      signed_sum exact;
      double most = 0;
      for (const double x : terms) exact += x, most = std::max(most, std::abs(x));
      CHECK(std::abs(first - exact.value()) <=
            0x1p-52 * std::abs(first) + most * 0x1p-97 * static_cast<double>(terms.size()));
    }
}

TEST_CASE("a binned sum is right where a sum in double loses its small terms") {
  std::vector<double> terms(1 << 12, 0x1p-53);
  terms.push_back(1);
  CHECK(sum_of(terms).value() == 1 + 0x1p-41);
  CHECK(sum_of({1e30, 1, -1e30, 1}).value() == 2);
  CHECK(sum_of({0x1p1000, 0x1p1000}).value() == 0x1p1001);
  const double least = std::numeric_limits<double>::denorm_min();
  CHECK(sum_of({least, least, least, -least}).value() == 2 * least);
  CHECK(sum_of({}).value() == 0);
  CHECK(sum_of({0, -3, 3}).value() == 0);
  CHECK(std::isnan(sum_of({1, std::numeric_limits<double>::infinity()}).value()));
  CHECK(std::isnan(sum_of({std::nan(""), 1}).value()));
}
