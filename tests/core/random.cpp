#include "talus/core/random.hpp"

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <set>
#include <vector>

using namespace talus;

TEST_CASE("philox gives the known answers of its authors") {
  using words = std::array<std::uint32_t, 4>;
  constexpr auto ones = ~std::uint32_t{0};
  static_assert(detail::philox({0, 0, 0, 0}, {0, 0}) ==
                words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  static_assert(detail::philox({ones, ones, ones, ones}, {ones, ones}) ==
                words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  static_assert(
      detail::philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
      words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("a stream is philox with its name as key and counter") {
  random_stream r(0x1122334455667788, 0x99aabbccddeeff00, 7);
  const std::array<std::uint32_t, 2> key{0x55667788, 0x11223344};
  for (std::uint32_t block = 0; block < 5; ++block) {
    const auto w = detail::philox({block, 7, 0xddeeff00, 0x99aabbcc}, key);
    CHECK(r.bits() == (w[0] | std::uint64_t{w[1]} << 32));
    CHECK(r.bits() == (w[2] | std::uint64_t{w[3]} << 32));
  }
  random_stream a(5, system_id{12}, 1), b(5, 12, 1);
  CHECK(a.bits() == b.bits());
}

TEST_CASE("streams of one name agree, all others differ") {
  std::set<std::uint64_t> first;
  int streams = 0;
  for (std::uint64_t seed : {0, 1, 2})
    for (std::uint64_t number = 0; number < 100; ++number)
      for (std::uint32_t purpose : {0, 1, 2}) {
        random_stream a(seed, number, purpose), b(seed, number, purpose);
        const auto x = a.bits();
        CHECK(x == b.bits());
        first.insert(x);
        ++streams;
      }
  CHECK(first.size() == std::size_t(streams));
}

TEST_CASE("draws are the same to the bit wherever they are made") {
  random_stream r(2024, 1);
  CHECK(r.uniform() == 0x1.43523a6e98597p-1);
  CHECK(r.uniform(0.6, 1.2) == 0x1.6ad7bb2889e4p-1);
}

TEST_CASE("uniform numbers fill their interval evenly") {
  random_stream r(1);
  const int n = 200000, bins = 20;
  std::vector<int> count(bins);
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const real x = r.uniform(-3, 5);
    REQUIRE((x >= -3 && x <= 5));
    ++count[std::min(bins - 1, int((x + 3) / 8 * bins))];
    sum += x;
    squares += x * x;
  }
  const double mean = sum / n, variance = squares / n - mean * mean;
  CHECK(std::abs(mean - 1) < 4 * std::sqrt(64.0 / 12 / n));
  CHECK(variance == doctest::Approx(64.0 / 12).epsilon(0.01));
  double chi2 = 0;
  for (int c : count) chi2 += std::pow(c - double(n) / bins, 2) / (double(n) / bins);
  CHECK(chi2 < 43.8);  // 19 degrees of freedom, probability 0.001
}

TEST_CASE("neighbouring streams are not correlated") {
  const int n = 100000;
  for (int which : {0, 1, 2}) {
    CAPTURE(which);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const auto stream = [&](int k) {
        return which == 0   ? random_stream(k)
               : which == 1 ? random_stream(9, k)
                            : random_stream(9, 9, k);
      };
      sum += (stream(i).uniform() - 0.5) * (stream(i + 1).uniform() - 0.5) * 12;
    }
    CHECK(std::abs(sum / n) < 4 / std::sqrt(double(n)));
  }
}

TEST_CASE("integers are equally likely") {
  random_stream r(3);
  std::vector<int> count(7);
  for (int i = 0; i < 70000; ++i) ++count.at(r.integer(7));
  double chi2 = 0;
  for (int c : count) chi2 += std::pow(c - 10000.0, 2) / 10000;
  CHECK(chi2 < 22.5);  // 6 degrees of freedom, probability 0.001
  CHECK(r.integer(1) == 0);
  const std::uint64_t large = (std::uint64_t{1} << 63) + 1;  // half of the draws are rejected
  for (int i = 0; i < 100; ++i) CHECK(r.integer(large) < large);
}

TEST_CASE("unit vectors have unit length and no preferred direction") {
  random_stream r(4);
  const int n = 100000;
  vec3 sum(0, 0, 0);
  mat3 squares = mat3::Zero();
  for (int i = 0; i < n; ++i) {
    const vec3 u = r.unit_vector();
    REQUIRE(std::abs(u.norm() - 1) < 1e-14);
    sum += u;
    squares += detail::outer(u, u);
  }
  CHECK((sum / n).norm() < 5 / std::sqrt(3.0 * n));
  CHECK((squares / n - mat3::Identity() / 3).norm() < 5 / std::sqrt(double(n)));
}

TEST_CASE("points in a ball are uniform in volume") {
  random_stream r(5);
  const int n = 100000;
  int inner = 0;
  vec3 sum(0, 0, 0);
  for (int i = 0; i < n; ++i) {
    const vec3 p = r.in_ball(2);
    REQUIRE(p.norm() <= 2 * (1 + 1e-15));
    inner += p.norm() < 1;
    sum += p;
  }
  CHECK(std::abs(inner / double(n) - 0.125) < 4 * std::sqrt(0.125 * 0.875 / n));
  CHECK((sum / n).norm() < 0.02);
}

TEST_CASE("rotations are uniform") {
  random_stream r(6);
  const int n = 100000;
  mat3 sum = mat3::Zero();
  double angle = 0;
  std::array<double, 4> squares{};
  for (int i = 0; i < n; ++i) {
    const quat q = r.rotation();
    REQUIRE(std::abs(q.norm() - 1) < 1e-14);
    sum += q.toRotationMatrix();
    for (int k = 0; k < 4; ++k) squares[k] += q.coeffs()[k] * q.coeffs()[k];
    angle += 2 * std::acos(std::min(1.0, std::abs(q.w())));
  }
  CHECK((sum / n).norm() < 5 / std::sqrt(double(n)));
  for (const double square : squares) CHECK(std::abs(square / n - 0.25) < 0.004);
  CHECK(angle / n == doctest::Approx(pi / 2 + 2 / pi).epsilon(0.005));  // Haar measure
}

TEST_CASE("bad bounds are refused") {
  random_stream r(7);
  CHECK_THROWS_WITH_AS(
      r.uniform(2, 1),
      "random numbers between 2 and 1: give two finite bounds, the lower one first",
      std::invalid_argument);
  CHECK_THROWS_AS(r.uniform(0, std::numeric_limits<real>::infinity()), std::invalid_argument);
  CHECK_THROWS_AS(r.uniform(std::numeric_limits<real>::quiet_NaN(), 1), std::invalid_argument);
  CHECK_THROWS_AS(r.integer(0), std::invalid_argument);
  CHECK(r.uniform(1, 1) == 1);
}
