// The torque-free asymmetric top against Jacobi's elliptic functions, and free rotation in general.
#include <doctest/doctest.h>

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <talus/observe/motion.hpp>
#include <vector>

#include "../scenes/solids.hpp"
#include "../validation/record.hpp"
#include "../validation/track.hpp"

using namespace talus;
using namespace talus::validation;
using tops = scenes::solids;

namespace {

const vec3 size{1, 2, 0.3};
const vec3 inertia = 0.6 * box{size}.inertia();
const real energy_tolerance = 1e-6;

real energy_of(const moment& m) {
  const vec3 w = m.orientation.conjugate() * m.angular_velocity;
  return 0.5 * inertia.dot(w.cwiseProduct(w));
}
vec3 momentum_of(const moment& m) {
  return m.orientation * vec3(inertia.cwiseProduct(m.orientation.conjugate() * m.angular_velocity));
}

/// The closed form for the box above, with w = (x > 0, y > 0, 0) at time 0: the moments of x, y and
/// z are the intermediate, the least and the largest one.
class closed_form {
 public:
  explicit closed_form(const vec3& w) {
    real i1 = inertia[1], i3 = inertia[2];
    const real i2 = inertia[0], twice_e = inertia.dot(w.cwiseProduct(w)),
               l2 = inertia.cwiseProduct(w).squaredNorm();
    about_y_ = l2 < twice_e * i2;  // the spin about y never changes sign, else that about z
    if (about_y_) std::swap(i1, i3);
    rate_ = std::sqrt((i3 - i2) * (l2 - twice_e * i1) / (i1 * i2 * i3));
    k_ = std::sqrt((i2 - i1) * (twice_e * i3 - l2) / ((i3 - i2) * (l2 - twice_e * i1)));
    complement_ = (l2 - twice_e * i2) * (i3 - i1) / ((i3 - i2) * (l2 - twice_e * i1));
    quarter_ = boost::math::ellint_1(k_);
    first_ = std::sqrt((twice_e * i3 - l2) / (i1 * (i3 - i1)));
    second_ = std::sqrt((twice_e * i3 - l2) / (i2 * (i3 - i2)));
    third_ = std::sqrt((l2 - twice_e * i1) / (i3 * (i3 - i1)));
  }
  [[nodiscard]] real period() const { return 4 * quarter_ / rate_; }
  /// Angular velocity in the frame of the body.
  [[nodiscard]] vec3 operator()(real t) const {
    REQUIRE(about_y_);
    real cn, unused;
    const real sn = boost::math::jacobi_elliptic(k_, quarter_ + rate_ * t, &cn, &unused);
    // Boost's dn is a quotient of two zeros at the quarter period.
    const real dn = std::sqrt(complement_ + k_ * k_ * cn * cn);
    return {second_ * sn, third_ * dn, -first_ * cn};
  }

 private:
  bool about_y_;
  real rate_, k_, complement_, quarter_, first_, second_, third_;
};

std::vector<moment> spin(const vec3& w, real dt, real time, int ranks = 1) {
  return follow<tops>(ranks, dt, static_cast<std::size_t>(std::lround(time / dt)),
                      [&](auto& world) {
                        world.material({});
                        // On four ranks it flies through three of the domains.
                        world.add_if_local(body{.shape = box{size},
                                                .position = {-3.05, -1.51, 0},
                                                .velocity = {0.1, 0.1, 0},
                                                .angular_velocity = w});
                      })[0];
}

struct errors {
  std::vector<real> flips;  ///< times at which the spin about the intermediate axis changes sign
  real energy = 0, momentum = 0, direction = 0, spin = 0;  ///< relative, the largest ones
};
errors errors_of(const std::vector<moment>& way, real dt) {
  errors e;
  const vec3 w0 = way[0].angular_velocity, l0 = momentum_of(way[0]);
  const real e0 = energy_of(way[0]);
  const closed_form exact(w0);
  real before = w0[0];
  for (std::size_t k = 1; k < way.size(); ++k) {
    const vec3 w = way[k].orientation.conjugate() * way[k].angular_velocity;
    if ((w[0] > 0) != (before > 0))
      e.flips.push_back((static_cast<real>(k) - w[0] / (w[0] - before)) * dt);
    before = w[0];
    const vec3 l = momentum_of(way[k]);
    e.energy = std::max(e.energy, std::abs(energy_of(way[k]) / e0 - 1));
    e.momentum = std::max(e.momentum, std::abs(l.norm() / l0.norm() - 1));
    e.direction = std::max(e.direction, (l - l0).norm() / l0.norm());
    e.spin = std::max(e.spin, (w - exact(static_cast<real>(k) * dt)).norm() / w0.norm());
  }
  return e;
}

}  // namespace

TEST_CASE("the moments of inertia and the period are those of the closed form") {
  CHECK((inertia - vec3(0.2045, 0.0545, 0.25)).norm() < 1e-12);
  CHECK(closed_form({5, 5e-3, 0}).period() == doctest::Approx(9.298477344).epsilon(1e-9));
  CHECK(closed_form({10, 1e-2, 0}).period() == doctest::Approx(4.649238672).epsilon(1e-9));
  CHECK(closed_form({1, 1e-3, 0}).period() == doctest::Approx(46.492386719).epsilon(1e-9));
  for (const vec3& w : {vec3(5, 5e-3, 0), vec3(1, 0.7, 0)}) {
    const closed_form exact(w);
    CHECK((exact(0) - w).norm() < 1e-9 * w.norm());
    // Euler's equations, by a central difference.
    for (const real t : {0.1, 1.3, 2.7}) {
      const vec3 now = exact(t), rate = (exact(t + 1e-4) - exact(t - 1e-4)) / 2e-4;
      const vec3 law = -now.cross(inertia.cwiseProduct(now)).cwiseQuotient(inertia);
      CHECK((rate - law).norm() < 1e-5 * w.squaredNorm());
    }
  }
}

TEST_CASE(
    "SPIN: 13 flips in 60 s at the right times; energy, momentum and the whole angular velocity as "
    "Jacobi's functions say, on 1 and on 4 ranks") {
  const real dt = 1.0 / 240;
  for (const auto& [w, ranks] : {std::pair(vec3(5, 5e-3, 0), 1), std::pair(vec3(5, 5e-3, 0), 4),
                                 std::pair(vec3(10, 1e-2, 0), 1), std::pair(vec3(1, 1e-3, 0), 1)}) {
    const std::string test = fmt::format("free top, spin {}, {} rank(s)", w[0], ranks);
    const errors e = errors_of(spin(w, dt, 60, ranks), dt);
    const real period = closed_form(w).period();
    const auto flips = std::floor((60 - period / 4) / (period / 2)) + 1;
    check_absolute(test, "flips in 60 s", flips, static_cast<double>(e.flips.size()), 0);
    REQUIRE(e.flips.size() > 1);
    real latest = 0;
    for (std::size_t k = 0; k < e.flips.size(); ++k)
      latest = std::max(latest, std::abs(e.flips[k] - (static_cast<real>(k) / 2 + 0.25) * period));
    check_relative(test, "first flip (s)", period / 4, e.flips[0], 1e-3);
    check_error(test, "largest error of the time of a flip, over the period", latest / period,
                1e-3);
    check_relative(test, "period (s)", period,
                   2 * (e.flips.back() - e.flips[0]) / static_cast<real>(e.flips.size() - 1), 1e-3);
    check_error(test, "max |E/E0 - 1|", e.energy, energy_tolerance);
    check_error(test, "max ||L|/L0 - 1|", e.momentum, energy_tolerance);
    check_error(test, "max |L - L0| / L0", e.direction, 1e-10);
    check_error(test, "max |w - w_exact| / w0, body frame", e.spin, 1e-5);
  }
}

TEST_CASE("energy and angular velocity of a top are of fourth order in dt") {
  const vec3 w{8, 4, 0};
  const errors coarse = errors_of(spin(w, 1.0 / 60, 10), 1.0 / 60),
               fine = errors_of(spin(w, 1.0 / 120, 10), 1.0 / 120);
  const std::string test = "free top, order in dt";
  check_at_least(test, "energy", 3.8, std::log2(coarse.energy / fine.energy));
  check_at_least(test, "angular velocity", 3.8, std::log2(coarse.spin / fine.spin));
}

TEST_CASE("whatever the time step, a fast top neither gains nor loses energy without end") {
  for (const real speed : {100., 500., 2000.}) {
    CAPTURE(speed);
    real early = 0, late = 0;
    const auto way = spin({speed, 0.3 * speed, 0}, 1.0 / 240, 20);
    for (std::size_t k = 1; k < way.size(); ++k) {
      real& largest = 2 * k < way.size() ? early : late;
      largest = std::max(largest, std::abs(energy_of(way[k]) / energy_of(way[0]) - 1));
    }
    MESSAGE("turns by ", speed / 240, " a step: energy error ", early, ", later ", late);
    CHECK(early < 1e-6);
    CHECK(late < 2 * early + 1e-9);
  }
}

TEST_CASE("a symmetric top precesses exactly, however large the step") {
  const box rod{{1, 1, 3}};
  const vec3 moments = rod.inertia() * rod.volume();
  const real tilt = 0.4, dt = 0.05;
  // L along z, the axis of the body tilted from it.
  const quat q0(rotation(vec3::UnitX(), tilt));
  const real length = 20;
  const vec3 w0 = q0 * vec3((q0.conjugate() * vec3(0, 0, length)).cwiseQuotient(moments));
  const auto way = follow<tops>(1, dt, 200, [&](auto& world) {
    world.material({});
    world.add_if_local(body<box>{.shape = rod, .angular_velocity = w0, .orientation = q0});
  })[0];
  real worst = 0;
  for (std::size_t k = 0; k < way.size(); ++k) {
    const quat turn(rotation(vec3::UnitZ(), length / moments[0] * dt * static_cast<real>(k)));
    const vec3 axis = turn * (q0 * vec3::UnitZ());
    worst = std::max(worst, (way[k].orientation * vec3::UnitZ() - axis).norm());
    worst = std::max(worst, (way[k].angular_velocity - turn * w0).norm() / w0.norm());
  }
  check_error("symmetric top, dt 1/20", "axis and angular velocity", worst, 1e-12);
}

TEST_CASE("a box that spins about any of its principal axes keeps its spin to round-off") {
  for (int axis = 0; axis < 3; ++axis) {
    const vec3 w = 3 * vec3::Unit(axis);
    const auto end = spin(w, 1.0 / 240, 1).back();
    CHECK((end.angular_velocity - w).norm() < 1e-12);
    CHECK(end.orientation.angularDistance(rotation(vec3::Unit(axis), 3)) < 1e-7);
  }
}
