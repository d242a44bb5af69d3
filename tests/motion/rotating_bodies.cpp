// Bodies that rotate side by side: the bits of single ones.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <talus/motion/rotating_bodies.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

bool same_bits(const vec3& a, const vec3& b) {
  for (int i = 0; i < 3; ++i)
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
  return true;
}
bool same_bits(const quat& a, const quat& b) {
  return same_bits(a.vec(), b.vec()) &&
         std::bit_cast<std::uint64_t>(a.w()) == std::bit_cast<std::uint64_t>(b.w());
}

}  // namespace

TEST_CASE("eight bodies at once rotate to the bit as one by one") {
  std::mt19937_64 random(11);
  const auto between = [&](real low, real high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  const auto vector = [&](real size) {
    return vec3(between(-size, size), between(-size, size), between(-size, size));
  };
  int different = 0, slow = 0;
  for (int n = 0; n < 20000; ++n) {
    rotating_bodies<real> all;
    std::array<rotating_body<real>, 8> alone;
    const real dt = between(0.001, 0.02);
    const auto count = static_cast<std::size_t>(between(1, 9));
    for (std::size_t k = 0; k < count; ++k) {
      rotating_body<real>& one = all[k];
      one.q = quat(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
      const int kind = static_cast<int>(between(0, 6));  // from rest to fast
      one.w = kind == 0 ? vec3(0, 0, 0) : vector(std::pow(10.0, kind - 4));
      one.turn = between(0, 1) < 0.3 ? vec3(0, 0, 0) : vector(between(0, 1) < 0.1 ? 1 : 1e-4);
      one.inertia = {between(0.5, 2), between(0.5, 2), between(0.5, 2)};
      const real symmetric = between(0, 1);
      if (symmetric < 0.2) one.inertia[static_cast<int>(between(0, 3))] = one.inertia[0];
      if (symmetric < 0.1) one.inertia = {1, 1, 1};
      slow += kind > 0 && kind < 4;
      alone[k] = one;
    }
    all.rotate(count, dt);
    for (std::size_t k = 0; k < count; ++k) {
      alone[k].rotate(dt);
      different += !same_bits(alone[k].w, all[k].w) || !same_bits(alone[k].q, all[k].q);
    }
  }
  CHECK(slow > 10000);
  CHECK(different == 0);
}

TEST_CASE("turn_midway is off by at most a sixth of the cube of the angle") {
  std::mt19937_64 random(12);
  const auto between = [&](real low, real high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  const auto vector = [&] { return vec3(between(-1, 1), between(-1, 1), between(-1, 1)); };
  real worst = 0;
  for (int n = 0; n < 20000; ++n) {
    const quat q =
        quat(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
    const real x = between(0.1, 1), y = between(0.1, 1);
    const vec3 inertia(x, y, between(std::abs(x - y), x + y));  // of some body
    const real angle = std::pow(10.0, between(-3, -0.5));
    const vec3 w = angle * vector().normalized();
    quat exact = q;
    (void)rotate_freely(exact, w, inertia, real(1));
    const quat found = turned(q, turn_midway(q, w, inertia, real(1)));
    const real off = 2 * (found.conjugate() * exact).vec().norm();
    worst = std::max(worst, (off - 1e-14) / (angle * angle * angle));
  }
  MESSAGE("off by at most ", worst, " of the cube");
  CHECK(worst < 1. / 6);
  CHECK(worst > 0.01);
}
