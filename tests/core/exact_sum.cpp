#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <talus/core/exact_batch.hpp>
#include <talus/core/exact_sum.hpp>
#include <vector>

using talus::detail::exact_sum;
using talus::detail::signed_sum;

namespace {

double sum_of(const std::vector<double>& terms) {
  exact_sum s;
  for (const double x : terms) s += x;
  return s;
}

}  // namespace

TEST_CASE("an exact sum is the same in any order and grouping, for terms of all sizes") {
  std::mt19937_64 random(20261122);
  for (int run = 0; run < 200; ++run) {
    CAPTURE(run);
    std::vector<double> terms(1 + random() % 300);
    for (double& x : terms)
      x = std::ldexp(static_cast<double>(random() >> 11), -static_cast<int>(random() % 1000));
    const double first = sum_of(terms);
    std::shuffle(terms.begin(), terms.end(), random);
    CHECK(sum_of(terms) == first);
    // In three parts, as on three ranks.
    std::array<double, exact_sum::digits + 1> total{}, part{};
    for (std::size_t k = 0; k < 3; ++k) {
      exact_sum s;
      for (std::size_t i = k; i < terms.size(); i += 3) s += terms[i];
      s.write(part);
      for (std::size_t d = 0; d < total.size(); ++d) total[d] += part[d];
    }
    exact_sum all;
    all.read(total);
    CHECK(all.value() == first);
  }
}

TEST_CASE("an exact sum is right where a sum in double loses its small terms") {
  std::vector<double> terms(1 << 12, 0x1p-53);
  terms.push_back(1);
  CHECK(sum_of(terms) == 1 + 0x1p-41);
  CHECK(sum_of({0x1p1000, 0x1p1000}) == 0x1p1001);
  CHECK(sum_of({std::numeric_limits<double>::denorm_min(),
                std::numeric_limits<double>::denorm_min()}) ==
        2 * std::numeric_limits<double>::denorm_min());
  CHECK(sum_of({}) == 0);
  CHECK(std::isnan(sum_of({1, std::numeric_limits<double>::infinity()})));
  CHECK(std::isnan(sum_of({std::nan(""), 1})));
}

TEST_CASE("terms of both signs leave what is small beside them, however often they alternate") {
  std::mt19937_64 random(20261126);
  signed_sum all;
  for (int k = 0; k < 2000; ++k) {
    signed_sum step;
    std::vector<double> terms(20);
    for (double& x : terms)
      x = std::ldexp(static_cast<double>(random() >> 11), static_cast<int>(random() % 200) - 100);
    for (const double x : terms) step += x;
    std::shuffle(terms.begin(), terms.end(), random);
    for (const double x : terms) step -= x;
    CHECK(step.value() == 0);
    step += k % 2 == 0 ? 0x1p-60 : -0x1p-61;
    CHECK(step.value() == (k % 2 == 0 ? 0x1p-60 : -0x1p-61));
    all += step;
    if (k % 3 == 0) exact_sum::cancel(all.plus, all.minus);
  }
  CHECK(all.value() == 1000 * 0x1p-61);
  signed_sum none = all;
  CHECK((none -= all).value() == 0);
}

TEST_CASE(
    "a batch adds what the single terms add, for numbers of any size, and overflows nowhere") {
  std::mt19937 random(3);
  std::uniform_real_distribution<> digits(-1, 1);
  std::uniform_int_distribution<> exponent(-1070, 1020), near(-3, 3);
  const auto check = [&](auto&& next) {
    talus::detail::signed_sum one_by_one, batched;
    {
      talus::detail::exact_batch batch(batched);
      for (int k = 0; k < 20000; ++k) {
        const double x = next();
        one_by_one += x, batch += x;
      }
    }
    CHECK(batched.value() == one_by_one.value());
    one_by_one -= batched;
    CHECK(one_by_one.value() == 0);
  };
  check([&] { return std::ldexp(digits(random), exponent(random)); });
  check([&] { return std::ldexp(digits(random), near(random)); });
  check([&] { return std::abs(std::ldexp(digits(random), near(random))); });
  check([] { return 2 - 0x1p-52; });
  int count = 0;
  check([&] { return std::ldexp(digits(random), -(++count % 300)); });  // far below the largest
  check([&] { return std::ldexp(digits(random), ++count % 300); });     // larger and larger
  check([] { return 0.0; });
  exact_sum sizes, sizes_in_batch;
  {
    talus::detail::exact_batch batch(sizes_in_batch);
    for (int k = 0; k < 1000; ++k) {
      const double x = std::ldexp(std::abs(digits(random)), -(k % 200));
      sizes += x, batch += x;
    }
  }
  CHECK(sizes.value() == sizes_in_batch.value());
  exact_sum broken;
  {
    talus::detail::exact_batch batch(broken);
    batch += std::nan("");
  }
  CHECK(std::isnan(broken.value()));
}

TEST_CASE("a sum times a number is the sum of the products, whatever its grouping") {
  std::mt19937 random(5);
  std::uniform_real_distribution<> digits(-1, 1);
  for (const double factor : {1.0, 2e-4, 1e-4 / 3, 12345.678, 0x1p-40}) {
    talus::detail::signed_sum all, some, others;
    double sum = 0;
    for (int k = 0; k < 1000; ++k) {
      const double x = std::ldexp(digits(random), k % 60 - 30);
      all += x, (k % 3 == 0 ? some : others) += x;
      sum += x;
    }
    const auto whole = all.times(factor);
    CHECK(whole.value() == doctest::Approx(factor * all.value()).epsilon(1e-15));
    talus::detail::signed_sum parts = some.times(factor);
    parts += others.times(factor);
    CHECK(parts.value() == whole.value());
    parts -= whole;
    CHECK(parts.value() == 0);
  }
  talus::detail::signed_sum one;
  one += -3.0;
  CHECK(one.times(0.5).value() == -1.5);
  CHECK(one.times(0).value() == 0);
}
