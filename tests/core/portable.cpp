// Sine, cosine, arc tangent, roots, powers, exponentials and logarithms of talus against those of
// the C library in long double: within the stated units in the last place, over all sizes of
// arguments.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <talus/core/portable_beta.hpp>
#include <talus/core/portable_powers.hpp>
#include <talus/core/portable_trigonometry.hpp>
#include <talus/core/quick_functions.hpp>
#include <talus/core/random.hpp>

using namespace talus;

namespace {

constexpr real infinity = std::numeric_limits<real>::infinity();

/// The error of x in units of the last place of the exact value.
real ulps(real x, long double exact) {
  const int exponent = std::max(std::ilogb(static_cast<real>(exact)), -1022);
  return static_cast<real>(std::abs(x - exact) / std::ldexp(1.0L, exponent - 52));
}

/// The largest error of f against g for arguments from draw(random).
template <class F, class G, class Draw>
real worst(F&& f, G&& g, Draw&& draw) {
  random_stream random(2026, 5);
  real most = 0;
  for (int k = 0; k < 200000; ++k) {
    const real x = draw(random);
    most = std::max(most, ulps(f(x), g(static_cast<long double>(x))));
  }
  return most;
}
/// Of either sign, all exponents from `low` to `high` equally likely.
auto any_size(int low, int high) {
  return [=](random_stream& random) {
    const int exponent = low + static_cast<int>(random.integer(std::uint64_t(high - low + 1)));
    return std::ldexp(random.uniform(0.5, 1), exponent) * (random.integer(2) == 0 ? 1 : -1);
  };
}
auto between(real low, real high) {
  return [=](random_stream& random) { return random.uniform(low, high); };
}

}  // namespace

TEST_CASE("sine and cosine are right to one unit in the last place, from tiny to huge angles") {
  for (const auto& [low, high] : {std::pair{-30, 3}, {3, 40}, {40, 1023}}) {
    CAPTURE(high);
    CHECK(worst(
              portable::sin, [](long double x) { return std::sin(x); }, any_size(low, high)) < 1);
    CHECK(worst(
              portable::cos, [](long double x) { return std::cos(x); }, any_size(low, high)) < 1);
    CHECK(worst(
              portable::tan, [](long double x) { return std::tan(x); }, any_size(low, high)) < 3);
  }
  // Next to multiples of pi/2, where nearly all digits cancel.
  const auto near = [](random_stream& random) {
    return static_cast<real>(random.integer(1 << 20)) * (pi / 2);
  };
  CHECK(worst(
            portable::sin, [](long double x) { return std::sin(x); }, near) < 1);
  CHECK(worst(
            portable::cos, [](long double x) { return std::cos(x); }, near) < 1);
  const real worst_of_all =
      std::ldexp(6381956970095103.0, 797);  // the double nearest to a multiple
  CHECK(ulps(portable::cos(worst_of_all), -4.6871659242546276e-19L) < 2);
  CHECK(portable::sin(0) == 0);
  CHECK(std::signbit(portable::sin(-0.0)));
  CHECK(portable::cos(0) == 1);
  CHECK(std::isnan(portable::sin(infinity)));
  CHECK(std::isnan(portable::cos(-infinity)));
}

TEST_CASE("arc tangent and arc cosine are right to two units in the last place") {
  random_stream random(7, 1);
  real most = 0;
  for (int k = 0; k < 200000; ++k) {
    const real y = any_size(-40, 40)(random), x = any_size(-40, 40)(random);
    most = std::max(most, ulps(portable::atan2(y, x), std::atan2(static_cast<long double>(y),
                                                                 static_cast<long double>(x))));
  }
  CHECK(most < 2);
  CHECK(worst(
            portable::acos, [](long double x) { return std::acos(x); }, between(-1, 1)) < 2);
  CHECK(portable::acos(1) == 0);
  for (const real y : {0.0, -0.0, 2.0, -2.0})
    for (const real x : {0.0, -0.0, 3.0, -3.0}) {
      CAPTURE(y);
      CAPTURE(x);
      CHECK(portable::atan2(y, x) == doctest::Approx(std::atan2(y, x)).epsilon(1e-15));
      CHECK(std::signbit(portable::atan2(y, x)) == std::signbit(y));
    }
}

TEST_CASE("roots are right to one unit in the last place") {
  CHECK(worst(
            portable::cbrt, [](long double x) { return std::cbrt(x); }, any_size(-1022, 1023)) <
        0.51);
  CHECK(portable::cbrt(27) == 3);
  CHECK(portable::cbrt(-0.001) == doctest::Approx(-0.1));
  CHECK(portable::cbrt(std::ldexp(1.0, -1074)) ==
        doctest::Approx(std::cbrt(std::ldexp(1.0, -1074))));
  CHECK(portable::cbrt(0) == 0);
  random_stream random(7, 2);
  real most = 0;
  for (const int size : {0, 600, -600})
    for (int k = 0; k < 100000; ++k) {
      const real x = any_size(size - 30, size + 30)(random),
                 y = any_size(size - 30, size + 30)(random);
      most = std::max(most, ulps(portable::hypot(x, y), std::hypot(static_cast<long double>(x),
                                                                   static_cast<long double>(y))));
    }
  CHECK(most < 1.3);
  CHECK(portable::hypot(3, 4) == 5);
  CHECK(portable::hypot(0, 0) == 0);
  CHECK(portable::hypot(-infinity, 1) == infinity);
  CHECK(portable::hypot(1e308, 1e308) == doctest::Approx(1.4142135623730951e308));
  CHECK(portable::hypot(4e-320, 3e-320) == doctest::Approx(5e-320));
}

TEST_CASE("exponentials, logarithms and powers are right to one or two units in the last place") {
  CHECK(worst(
            portable::exp, [](long double x) { return std::exp(x); }, between(-700, 700)) < 1);
  CHECK(worst(
            portable::exp, [](long double x) { return std::exp(x); }, any_size(-60, 2)) < 1);
  CHECK(portable::exp(0) == 1);
  CHECK(portable::exp(2000) == infinity);
  CHECK(portable::exp(710) == infinity);
  CHECK(portable::exp(-2000) == 0);
  CHECK(portable::exp(-740) == doctest::Approx(std::exp(-740)));
  CHECK(std::isnan(portable::exp(std::nan(""))));

  const auto positive = [](random_stream& random) {
    return std::abs(any_size(-1070, 1023)(random));
  };
  CHECK(worst(
            portable::log, [](long double x) { return std::log(x); }, positive) < 0.51);
  CHECK(worst(
            portable::log, [](long double x) { return std::log(x); }, between(0.5, 2)) < 0.51);
  CHECK(portable::log(1) == 0);
  CHECK(portable::log(0) == -infinity);
  CHECK(portable::log(infinity) == infinity);
  CHECK(std::isnan(portable::log(-1)));
  CHECK(portable::acosh(1) == 0);
  CHECK(worst(
            portable::acosh, [](long double x) { return std::acosh(x); }, between(2, 100)) < 3);

  random_stream random(7, 3);
  real most = 0;
  for (int k = 0; k < 200000; ++k) {
    const real x = std::abs(any_size(-300, 300)(random)), y = random.uniform(-3.0, 3.0);
    most = std::max(most, ulps(portable::pow(x, y),
                               std::pow(static_cast<long double>(x), static_cast<long double>(y))));
  }
  for (int k = 0; k < 200000; ++k) {  // as a damping per unit of time and a time step
    const real x = random.uniform(0.0, 1.0), y = std::ldexp(random.uniform(), -8);
    most = std::max(most, ulps(portable::pow(x, y),
                               std::pow(static_cast<long double>(x), static_cast<long double>(y))));
  }
  CHECK(most < 1.5);
  CHECK(portable::pow(2, 10) == 1024);
  CHECK(portable::pow(0, 0.1) == 0);
  CHECK(portable::pow(0, 0) == 1);
  CHECK(portable::pow(10, -3) == 0.001);
  CHECK(portable::pow(10, 400) == infinity);
  CHECK(portable::pow(10, -400) == 0);
}

TEST_CASE("quick powers are right to a few units in the last place, the beta function to 2e-14") {
  random_stream random(5, 6);
  real power = 0, beta = 0;
  for (int k = 0; k < 100000; ++k) {
    const real x = std::exp(random.uniform(-40.0, 1.0)), e = random.uniform(-1.0, 8.0);
    const real wanted = std::pow(x, e);
    power = std::max(
        power, std::abs(detail::quick_pow(x, e) / wanted - 1) / (1 + std::abs(std::log(wanted))));
  }
  for (int k = 0; k < 3000; ++k) {
    const real x = random.uniform(0.1, 5.0), y = random.uniform(0.1, 5.0);
    const long double wanted = std::tgamma(static_cast<long double>(x)) *
                               std::tgamma(static_cast<long double>(y)) /
                               std::tgamma(static_cast<long double>(x) + y);
    beta = std::max(beta, static_cast<real>(std::abs(portable::beta(x, y) / wanted - 1)));
  }
  MESSAGE("powers ", power, ", beta ", beta);
  CHECK(power < 6e-16);
  CHECK(beta < 2e-14);
  CHECK(detail::quick_pow(0, 0.3) == 0);
  CHECK(detail::quick_pow(0.7, 1) == 0.7);
  CHECK(detail::quick_pow(1, 0.3) == 1);
  CHECK(portable::beta(0.5, 0.5) == doctest::Approx(pi).epsilon(1e-15));
}

TEST_CASE("the quick root and logarithm are right to a few units in the last place") {
  random_stream random(3, 4);
  const auto of_size = any_size(-900, 900);
  real root = 0, logarithm = 0;
  for (int k = 0; k < 100000; ++k) {
    const real x = std::abs(of_size(random));
    root = std::max(root, std::abs(detail::quick_cbrt(x) / std::cbrt(x) - 1));
    const real y = random.uniform(1e-3, 1e3);
    const real wanted = std::log(y);
    logarithm = std::max(logarithm, std::abs(detail::quick_log(y) - wanted) / std::abs(wanted));
  }
  CHECK(root < 1e-15);
  CHECK(logarithm < 1e-14);
  CHECK(detail::quick_cbrt(0) == 0);
  CHECK(detail::quick_log(1) == 0);
}
