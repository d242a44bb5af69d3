// Vectors, matrices and quaternions agree with Eigen's, and convert from and to them.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cstdint>
#include <random>
#include <sstream>
#include <type_traits>

#include "../generator.hpp"
#include "talus/core/math.hpp"

using namespace talus;

namespace {

bool close(const vec3& a, const Eigen::Vector3d& b) {
  return (Eigen::Vector3d(a) - b).norm() <= 1e-14 * (1 + b.norm());
}
bool close(const mat3& a, const Eigen::Matrix3d& b) {
  return (Eigen::Matrix3d(a) - b).norm() <= 1e-13 * (1 + b.norm());
}
bool close(const quat& a, const Eigen::Quaterniond& b) {
  return (Eigen::Quaterniond(a).coeffs() - b.coeffs()).norm() <= 1e-14 * (1 + b.norm());
}

}  // namespace

TEST_CASE("vectors, matrices and quaternions are nothing but their numbers") {
  CHECK(std::is_trivially_copyable_v<vec3>);
  CHECK(std::is_trivially_copyable_v<mat3>);
  CHECK(std::is_trivially_copyable_v<quat>);
  CHECK(sizeof(vec3) == 3 * sizeof(real));
  CHECK(sizeof(mat3) == 9 * sizeof(real));
  CHECK(sizeof(quat) == 4 * sizeof(real));
}

TEST_CASE("operations give what those of Eigen give") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    generator random{std::mt19937_64(seed)};
    for (int k = 0; k < 300; ++k) {
      const vec3 a = random.point(3), b = random.point(3);
      const Eigen::Vector3d A = a, B = b;
      CHECK(a.dot(b) == doctest::Approx(A.dot(B)));
      CHECK(a.norm() == doctest::Approx(A.norm()));
      CHECK(close(a.cross(b), A.cross(B)));
      CHECK(close(a + 2 * b - a / 3, A + 2 * B - A / 3));
      CHECK(close(a.normalized(), A.normalized()));
      CHECK(close(a.cwiseProduct(b), A.cwiseProduct(B)));
      CHECK(close(a.cwiseQuotient(b), A.cwiseQuotient(B)));
      CHECK(close(a.cwiseMin(b), A.cwiseMin(B)));
      CHECK(close(a.cwiseMax(b), A.cwiseMax(B)));
      CHECK(close(a.cwiseAbs(), A.cwiseAbs()));
      CHECK(a.minCoeff() == A.minCoeff());
      int mine = -1, its = -1;
      CHECK(a.maxCoeff(&mine) == A.maxCoeff(&its));
      CHECK(mine == its);

      const quat q = random.turn(), p = random.turn();
      const Eigen::Quaterniond Q = q, P = p;
      CHECK(close(q * p, Q * P));
      CHECK(close(q * a, Q * A));
      CHECK(close(q.conjugate(), Q.conjugate()));
      CHECK(close(q.inverse(), Q.inverse()));
      CHECK(close(q.toRotationMatrix(), Q.toRotationMatrix()));
      CHECK(close(quat(q.toRotationMatrix()), Eigen::Quaterniond(Q.toRotationMatrix())));
      CHECK(q.angularDistance(p) == doctest::Approx(Q.angularDistance(P)).epsilon(1e-7));

      const mat3 m = q.toRotationMatrix() + detail::outer(a, b) + detail::diagonal_matrix(b);
      const Eigen::Matrix3d M = m;
      CHECK(close(m * q.toRotationMatrix(), M * Q.toRotationMatrix()));
      CHECK(close(m * a, M * A));
      CHECK(close(m.transpose(), M.transpose()));
      CHECK(m.determinant() == doctest::Approx(M.determinant()));
      CHECK(m.norm() == doctest::Approx(M.norm()));
      CHECK(close(m.col(1), M.col(1)));
      CHECK(close(m.row(2), M.row(2).transpose()));
      CHECK(close(m.diagonal(), M.diagonal()));
      if (std::abs(m.determinant()) > 0.1) {
        CHECK((Eigen::Matrix3d(m.inverse()) - M.inverse()).norm() < 1e-11 * M.inverse().norm());
      }
    }
  }
}

TEST_CASE("expressions, turns and numbers of Eigen convert") {
  const Eigen::Vector3d e(1, 2, 3);
  const vec3 sum = e + e;
  CHECK(sum == vec3(2, 4, 6));
  const quat turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()));
  CHECK(turn.isApprox(rotation({0, 1, 0}, 0.7), 1e-14));
  const vec3 none{};
  CHECK(none == vec3(0, 0, 0));
  CHECK(none.normalized() == none);
  CHECK(vec3(1, 2, 3).isApprox(vec3(1, 2, 3 + 1e-13)));
  CHECK_FALSE(vec3(1, 2, 3).isApprox(vec3(1, 2, 3.1)));
  std::ostringstream text;
  text << vec3(1, 2.5, -3) << '|' << quat(1, 0, 0, 0);
  CHECK(text.str() == "1 2.5 -3|1 0 0 0");
}
