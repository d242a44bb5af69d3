// The scenes of ./dev bench joints, their reference solutions and their checker. Values are those
// of IFToMM's library of computational benchmark problems and of the test set for IVP solvers of
// Bari.
// alone
#include <doctest/doctest.h>

#include "../../benchmarks/joints/reference.hpp"

using namespace bench::joints;

TEST_CASE("two four-bar mechanisms are where the library says after 10 s") {
  const Eigen::Vector2d y = four_bars(2, 10);
  CHECK(std::abs(std::sin(y[0]) - 0.3284581) < 1e-6);
  CHECK(std::abs(std::cos(y[0]) - 0.9445185) < 1e-6);
  CHECK(std::abs(y[1] * std::cos(y[0]) - 1.4230514) < 1e-6);
  CHECK(std::abs(-y[1] * std::sin(y[0]) + 0.4948688) < 1e-6);
}

TEST_CASE("the equations with constraints agree with those of one coordinate") {
  const scene s = scene_of("A02_2");
  dae mechanism(s);
  for (int i = 0; i < 10; ++i) mechanism.step(0.01);
  const Eigen::Vector2d y = four_bars(2, 0.1);
  const std::vector<double> corner = values(s, mechanism.states());
  CHECK(std::abs(corner[0] - std::sin(y[0])) < 1e-9);
  CHECK(std::abs(corner[1] - std::cos(y[0])) < 1e-9);
}

TEST_CASE("Andrews' mechanism has the angles of the test set after 0.03 s") {
  const scene s = scene_of("A03");
  dae mechanism(s);
  for (int i = 0; i < 300; ++i) mechanism.step(1e-4);
  const Eigen::VectorXd& turned = mechanism.turned();
  const double by[7] = {turned[0], turned[1] - turned[0], turned[2], turned[3] - turned[4],
                        turned[4], turned[5] - turned[6], turned[6]};
  const double published[7] = {15.81077119629904,   -15.75637105984298, 0.04082224013073101,
                               -0.5347301163226948, 0.5244099658805304, 0.5347301163226948,
                               1.048080741042263};
  for (int i = 0; i < 7; ++i) CHECK(std::abs(andrews_angles[i] + by[i] - published[i]) < 1e-8);
  CHECK(largest_gap(s, mechanism.states()) < 1e-15);
}

TEST_CASE("an overconstrained loop keeps its energy and its joints") {
  const scene s = scene_of("A04");
  dae mechanism(s);
  const double before = energy(s, mechanism.states());
  for (int i = 0; i < 50; ++i) mechanism.step(0.02);
  CHECK(std::abs(energy(s, mechanism.states()) - before) < 1e-9);
  CHECK(largest_gap(s, mechanism.states()) < 1e-14);
}

TEST_CASE("the slider of the governor rises, and half the step changes nothing") {
  scene s = scene_of("A05");
  s.duration = 0.5;
  const auto coarse = reference(s, 1e-5), fine = reference(s, 5e-6);
  CHECK(std::abs(coarse.back()[1] - fine.back()[1]) < 1e-9);
  CHECK(coarse.back()[1] > 0.5);
}

TEST_CASE("joints hold at the start, in positions and in velocities") {
  for (const std::string& name : scene_names()) {
    CAPTURE(name);
    const scene s = scene_of(name);
    std::vector<state> later = start_of(s);
    CHECK(largest_gap(s, later) < 1e-14);
    const double h = 1e-6;  // gaps of wrong velocities grow with h, those of right ones with h²
    for (state& b : later) {
      b.position += h * b.velocity;
      if (b.spin.norm() > 0)
        b.orientation =
            turn(Eigen::AngleAxisd(h * b.spin.norm(), b.spin.normalized())) * b.orientation;
    }
    CHECK(largest_gap(s, later) < 1e-10);
  }
}

TEST_CASE("a gap, a wrong axis and a shifted slider are seen") {
  scene s = scene_of("A05");
  std::vector<state> now = start_of(s);
  now[1].position.y() += 0.1;  // along the slider
  CHECK(largest_gap(s, now) < 1e-14);
  now[1].position.x() += 1e-3;
  CHECK(std::abs(largest_gap(s, now) - 1e-3) < 1e-14);
  now = start_of(s);
  now[1].orientation = turn(Eigen::AngleAxisd(1e-3, vec::UnitY()));
  CHECK(std::abs(largest_gap(s, now) - 1e-3) < 1e-8);
  now = start_of(s);
  now[0].position.x() = std::nan("");
  CHECK_FALSE(largest_gap(s, now) < 1);
}
