// The torque-free asymmetric top against Jacobi's elliptic functions, and free rotation in general.
#include <doctest/doctest.h>

#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;
using tops = scenario<bodies<box>, transport<serial>>;

namespace {

/// Complete elliptic integral of the first kind, by the arithmetic-geometric mean.
real complete_integral(real k2) {
  real a = 1, b = std::sqrt(1 - k2);
  while (std::abs(a - b) > 1e-15 * a) {
    const real mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return pi / (2 * a);
}

/// Period of the angular velocity in the body frame, for spins near the intermediate axis.
real period_of(vec3 inertia, vec3 w) {
  // Sort the axes by their moments.
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j)
      if (inertia[j] > inertia[j + 1])
        std::swap(inertia[j], inertia[j + 1]), std::swap(w[j], w[j + 1]);
  real I1 = inertia[0], I3 = inertia[2];
  const real I2 = inertia[1], E = 0.5 * inertia.dot(w.cwiseProduct(w)),
             L2 = inertia.cwiseProduct(w).squaredNorm();
  if (L2 < 2 * E * I2) std::swap(I1, I3);
  const real wp = std::sqrt((I3 - I2) * (L2 - 2 * E * I1) / (I1 * I2 * I3));
  const real k2 = (I2 - I1) * (2 * E * I3 - L2) / ((I3 - I2) * (L2 - 2 * E * I1));
  return 4 * complete_integral(k2) / wp;
}

struct run {
  std::vector<real> flips;  ///< times at which the spin about the intermediate axis changes sign
  real energy_error = 0, late_energy_error = 0, momentum_error = 0;
};

run spin(const vec3& w0, real dt, real time) {
  serial::link link;
  world<tops> w(link);
  w.material({});
  const auto h = w.add(body{.shape = box{{1, 2, 0.3}}, .angular_velocity = w0});
  const auto start = measure_motion(w);
  run r;
  real before = w0[0];
  for (int k = 1; k * dt <= time; ++k) {
    w.step(dt);
    const real now = (w[h].orientation().conjugate() * w[h].angular_velocity())[0];
    if ((now > 0) != (before > 0)) r.flips.push_back((k - now / (now - before)) * dt);
    before = now;
    const auto m = measure_motion(w);
    const real error = std::abs(m.kinetic_energy / start.kinetic_energy - 1);
    real& largest = k * dt < time / 2 ? r.energy_error : r.late_energy_error;
    largest = std::max(largest, error);
    r.momentum_error =
        std::max(r.momentum_error, (m.angular_momentum - start.angular_momentum).norm() /
                                       start.angular_momentum.norm());
  }
  return r;
}

}  // namespace

TEST_CASE("the moments of inertia and the period are those of the closed form") {
  const vec3 inertia = 0.6 * box{{1, 2, 0.3}}.inertia();
  CHECK((inertia - vec3(0.2045, 0.0545, 0.25)).norm() < 1e-12);
  CHECK(period_of(inertia, {5, 5e-3, 0}) == doctest::Approx(9.298477344).epsilon(1e-9));
  CHECK(period_of(inertia, {10, 1e-2, 0}) == doctest::Approx(4.649238672).epsilon(1e-9));
  CHECK(period_of(inertia, {1, 1e-3, 0}) == doctest::Approx(46.492386719).epsilon(1e-9));
}

TEST_CASE(
    "SPIN: 13 flips in 60 s at the right times, momentum to round-off, energy without drift") {
  const vec3 inertia = box{{1, 2, 0.3}}.inertia();
  for (const vec3& w : {vec3(5, 5e-3, 0), vec3(1, 1e-3, 0)}) {
    CAPTURE(w[0]);
    const run r = spin(w, 1.0 / 240, 60);
    const real period = period_of(inertia, w);
    CHECK(r.flips.size() == static_cast<std::size_t>(60 / period * 2 + 0.5));
    REQUIRE(!r.flips.empty());
    CHECK(r.flips[0] == doctest::Approx(period / 4).epsilon(1e-3));
    if (r.flips.size() > 2) {
      const real measured =
          2 * (r.flips.back() - r.flips[0]) / static_cast<real>(r.flips.size() - 1);
      MESSAGE("period ", measured, ", closed form ", period, ", error ", measured / period - 1);
      CHECK(measured == doctest::Approx(period).epsilon(1e-3));
    }
    MESSAGE("spin ", w[0], ": ", r.flips.size(), " flips, energy error ", r.energy_error,
            " in the first half, ", r.late_energy_error, " in the second, momentum ",
            r.momentum_error);
    CHECK(r.momentum_error < 1e-11);
    CHECK(r.energy_error < 1e-3);
    CHECK(r.late_energy_error < 1.05 * r.energy_error);
  }
}

TEST_CASE("the error of the energy of a top is of second order in dt") {
  const real coarse = spin({5, 5e-3, 0}, 1.0 / 120, 10).energy_error,
             fine = spin({5, 5e-3, 0}, 1.0 / 240, 10).energy_error;
  MESSAGE("energy error ", coarse, " at 1/120, ", fine, " at 1/240: order ",
          std::log2(coarse / fine));
  CHECK(std::log2(coarse / fine) > 1.8);
}

TEST_CASE("a box that spins about any of its principal axes keeps its spin to round-off") {
  for (int axis = 0; axis < 3; ++axis) {
    const vec3 w = 3 * vec3::Unit(axis);
    serial::link link;
    world<tops> world(link);
    world.material({});
    const auto h =
        world.add(body{.shape = box{{1, 2, 0.3}}, .velocity = {1, 2, 3}, .angular_velocity = w});
    for (int k = 0; k < 240; ++k) world.step(1.0 / 240);
    CHECK((world[h].angular_velocity() - w).norm() < 1e-12);
    CHECK((world[h].position() - vec3(1, 2, 3)).norm() < 1e-12);
    CHECK(world[h].orientation().angularDistance(
              quat(Eigen::AngleAxis<real>(3, vec3::Unit(axis)))) < 1e-7);
  }
}
