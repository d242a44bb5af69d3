// The Coulomb problem of one contact: its law, and agreement with a search over all directions.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <talus/constraint/coulomb.hpp>
#include <vector>

using namespace talus;
using detail::solve_coulomb;

namespace {

struct problem {
  mat3 W;
  vec3 b;
  real mu;
};

/// The deviation of r from the law: no pull, inside the cone, no penetration, complementarity, and
/// friction against the sliding, at its limit if there is any. Relative to the terms of W r + b.
struct violation {
  real normal = 0, cone = 0, approach = 0, complementarity = 0, direction = 0, limit = 0, power = 0;
  [[nodiscard]] real largest() const {
    return std::max({normal, cone, approach, complementarity, direction, limit, power});
  }
};

violation judge(const problem& p, const vec3& r) {
  const vec3 u = p.W * r + p.b;
  const real forces = r.norm(), speeds = p.W.norm() * forces + p.b.norm();
  const real pressed = std::hypot(r[1], r[2]), slip = std::hypot(u[1], u[2]);
  violation v;
  if (speeds == 0) return v;
  v.approach = std::max(real{0}, -u[0]) / speeds;
  if (forces == 0) return v;
  v.normal = std::max(real{0}, -r[0]) / forces;
  v.cone = std::max(real{0}, pressed - p.mu * r[0]) / forces;
  v.complementarity = std::abs(u[0] * r[0]) / (speeds * forces);
  v.direction = std::abs(u[1] * r[2] - u[2] * r[1]) / (speeds * forces);
  v.limit = slip * std::abs(p.mu * r[0] - pressed) / (speeds * forces * (1 + p.mu));
  v.power = std::max(real{0}, u[1] * r[1] + u[2] * r[2]) / (speeds * forces);
  return v;
}

/// All impulses that satisfy the law, found by a search over the directions of sliding.
std::vector<vec3> by_search(const problem& p) {
  if (p.b[0] >= 0) return {vec3(0, 0, 0)};
  std::vector<vec3> found;
  const vec3 stick = -p.W.inverse() * p.b;
  if (stick[0] >= 0 && std::hypot(stick[1], stick[2]) <= p.mu * stick[0]) found.push_back(stick);
  const auto at = [&](real angle) -> vec3 {
    const vec3 d{1, p.mu * std::cos(angle), p.mu * std::sin(angle)};
    return -p.b[0] / p.W.row(0).dot(d) * d;
  };
  const auto across = [&](real angle) {
    const vec3 u = p.W * at(angle) + p.b;
    return u[2] * std::cos(angle) - u[1] * std::sin(angle);
  };
  const int n = 2000;
  for (int k = 0; k < n; ++k) {
    real low = 2 * pi * k / n, high = 2 * pi * (k + 1) / n;
    if ((across(low) > 0) == (across(high) > 0)) continue;
    for (int i = 0; i < 60; ++i) {
      const real mid = 0.5 * (low + high);
      ((across(mid) > 0) == (across(low) > 0) ? low : high) = mid;
    }
    const vec3 r = at(low), u = p.W * r + p.b;
    if (r[0] >= 0 && u[1] * r[1] + u[2] * r[2] <= 0) found.push_back(r);
  }
  return found;
}

class dice {
 public:
  explicit dice(unsigned seed) : engine_(seed) {}
  real between(real a, real b) { return std::uniform_real_distribution<real>(a, b)(engine_); }
  vec3 vector(real size = 1) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  /// Symmetric positive definite with eigenvalues from 1 to 1/condition.
  mat3 matrix(real condition) {
    const quat q =
        quat(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
    const mat3 turn = q.toRotationMatrix();
    const vec3 values{1, std::pow(condition, -between(0, 1)), 1 / condition};
    const mat3 W = turn * detail::diagonal_matrix(values) * turn.transpose();
    return 0.5 * (W + W.transpose());
  }

 private:
  std::mt19937 engine_;
};

template <class Make>
real worst(unsigned seed, int count, Make&& make) {
  INFO("seed ", seed);
  dice random(seed);
  real worst = 0;
  for (int k = 0; k < count; ++k) {
    const problem p = make(random);
    const vec3 r = solve_coulomb(p.W, p.b, p.mu);
    const real error = judge(p, r).largest();
    if (!(error <= worst)) worst = error;
    if (!(error < 1e-12)) {
      INFO("case ", k, ": mu ", p.mu, ", b ", p.b, ", W ", p.W, ", r ", r);
      CHECK(error < 1e-12);
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the impulse of one contact fulfils Coulomb's law to 1e-12 for random W, b and mu") {
  const real e = worst(1, 200000, [](dice& d) {
    return problem{d.matrix(d.between(1, 10)), d.vector(), d.between(0, 1.5)};
  });
  MESSAGE("largest violation ", e);
  CHECK(e < 1e-12);
}

TEST_CASE("so it does for matrices of condition 1e6, any scale, small and huge friction") {
  for (const real condition : {1e2, 1e4, 1e6})
    for (const real scale : {1e-9, 1., 1e9})
      for (const real mu : {0., 1e-12, 1e-3, 0.3, 1., 10., 1e6}) {
        CAPTURE(condition);
        CAPTURE(scale);
        CAPTURE(mu);
        const real e = worst(2, 3000, [&](dice& d) {
          return problem{scale * d.matrix(condition), d.vector(), mu};
        });
        CHECK(e < 1e-12);
      }
}

TEST_CASE("so it does where the sticking impulse lies on the cone, or nearly so") {
  for (const real off : {0., 1e-15, -1e-15, 1e-12, -1e-12, 1e-8, -1e-8, 1e-4, -1e-4}) {
    CAPTURE(off);
    const real e = worst(3, 20000, [&](dice& d) {
      problem p{d.matrix(d.between(1, 100)), {}, d.between(0.05, 1)};
      const real angle = d.between(0, 2 * pi), t = p.mu * (1 + off);
      p.b = -p.W * vec3(1, t * std::cos(angle), t * std::sin(angle));
      return p;
    });
    CHECK(e < 1e-12);
  }
}

TEST_CASE(
    "so it does where the contact just parts, or the velocity is purely normal or tangential") {
  worst(4, 20000, [](dice& d) {
    return problem{d.matrix(20), {0, d.between(-1, 1), d.between(-1, 1)}, 0.4};
  });
  worst(5, 20000, [](dice& d) { return problem{d.matrix(20), {d.between(-1, 0), 0, 0}, 0.4}; });
  worst(6, 20000, [](dice& d) {
    return problem{
        d.matrix(20), {-1e-14 * d.between(0, 1), d.between(-1, 1), d.between(-1, 1)}, 0.4};
  });
  CHECK(solve_coulomb(mat3::Identity(), {0, 0, 0}, 0.5) == vec3(0, 0, 0));
  CHECK(solve_coulomb(mat3::Identity(), {1, 5, 5}, 0.5) == vec3(0, 0, 0));
  CHECK(solve_coulomb(2 * mat3::Identity(), {-1, 5, 5}, 0) == vec3(0.5, 0, 0));
}

TEST_CASE("the impulse agrees with a search over all directions of sliding") {
  const unsigned seed = 7;
  INFO("seed ", seed);
  dice random(seed);
  int several = 0;
  real furthest = 0;
  for (int k = 0; k < 2000; ++k) {
    const problem p{random.matrix(random.between(1, 10)), random.vector(), random.between(0.01, 1)};
    // Above this friction, sliding in some direction would pull: the search does not cover that.
    if (p.mu * std::hypot(p.W(1, 0), p.W(2, 0)) > 0.9 * p.W(0, 0)) continue;
    const vec3 r = solve_coulomb(p.W, p.b, p.mu);
    const auto all = by_search(p);
    REQUIRE(!all.empty());
    several += all.size() > 1;
    real nearest = 1e300;
    for (const vec3& s : all) nearest = std::min(nearest, (r - s).norm() / (1 + s.norm()));
    furthest = std::max(furthest, nearest);
    if (!(nearest < 1e-9)) {
      INFO("case ", k, ": r ", r, ", found ", all.size(), ", first ", all[0]);
      CHECK(nearest < 1e-9);
    }
  }
  MESSAGE("largest distance ", furthest, "; ", several, " problems with more than one answer");
  CHECK(furthest < 1e-9);
}
