#pragma once
// The scenes of `./dev bench joints`: IFToMM's library of computational benchmark problems, A01 to
// A05, a chain with a heavy end, and a grid.
#include <cmath>
#include <stdexcept>

#include "scene.hpp"

namespace bench::joints {

/// Moments of a rod along body x: length l, square section of width w.
inline vec rod_inertia(double m, double l, double w) {
  const double across = m * (l * l + w * w) / 12;
  return {m * w * w / 6, across, across};
}

/// Moment of the ball of radius 0.05 m that stands for the point mass: engines need a positive one.
constexpr double pendulum_inertia = 1e-3;

inline scene a01() {
  scene s{.name = "A01"};
  s.bodies = {{1, vec::Constant(pendulum_inertia), {.position = {-1, 0, 0}}}};
  s.joints = {{kind::hinge, ground, 0, vec::Zero()}};
  s.probes = {{0, {-1, 0, 0}}};
  s.error_is = "largest distance of the mass from the reference, m";
  return s;
}

/// `n` windows of 2 n + 1 rods; the corners are the points (i, 0) and (i, 1).
inline scene a02(int n) {
  scene s{.name = "A02_" + std::to_string(n)};
  const turn up(Eigen::AngleAxisd(pi / 2, vec::UnitZ()));
  // Thin in the plane of motion: only the moment about z counts, and it is m l² / 12.
  const vec inertia{1e-3, 1. / 12, 1. / 12};
  for (int i = 0; i <= n; ++i) {
    s.bodies.push_back({1, inertia, {{i * 1., 0.5, 0}, up, {0.5, 0, 0}, {0, 0, -1}}});
    s.joints.push_back({kind::hinge, ground, i, {i * 1., 0, 0}});
  }
  for (int i = 0; i < n; ++i) {
    s.bodies.push_back({1, inertia, {{i + 0.5, 1, 0}, turn::Identity(), {1, 0, 0}, vec::Zero()}});
    s.joints.push_back({kind::hinge, i, n + 1 + i, {i * 1., 1, 0}});
    s.joints.push_back({kind::hinge, i + 1, n + 1 + i, {i + 1., 1, 0}});
  }
  s.probes = {{0, {0, 1, 0}}};
  s.error_is = "largest distance of the corner B0 from the reference, m";
  return s;
}

/// Angles of Andrews' squeezing mechanism at the start: beta, Theta, gamma, Phi, delta, Omega,
/// epsilon.
constexpr double andrews_angles[7] = {-0.0617138900142764496, 0,
                                      0.455279819163070380,   0.222668390165885885,
                                      0.487364979543842551,   -0.222668390165885885,
                                      1.23054744454982119};

/// Parameters of the test set for IVP solvers of Bari.
inline scene a03() {
  constexpr double mass[7] = {.04325, .00365, .02373, .00706, .07050, .00706, .05498};
  constexpr double moment[7] = {2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7,
                                1.169e-5, 5.667e-7, 1.912e-5};
  const vec a{-.06934, -.00227, 0}, b{-.03635, .03273, 0}, c{.014, .072, 0};
  const auto [be, th, ga, ph, de, om, ep] = andrews_angles;
  // x along the angle, y across it
  const auto along = [](double angle, double x, double y) -> vec {
    return {x * std::cos(angle) - y * std::sin(angle), x * std::sin(angle) + y * std::cos(angle),
            0};
  };
  const vec end_1 = along(be, .007, 0);            // of the crank
  const vec e = end_1 + along(be + th, -.028, 0);  // where four bodies meet
  const vec f = a + along(de, .04, 0);             // of bodies 4 and 5
  const vec g = a + along(ep, 0, -.04);            // of bodies 6 and 7
  const vec d = b + along(ga, .02, -.018);         // of the spring
  scene s{.name = "A03", .duration = 0.03, .gravity = vec::Zero(), .length = 0.04};
  const vec centres[7] = {along(be, .00092, 0),           end_1 + along(be + th, -.0115, 0),
                          b + along(ga, .01043, -.01874), f + along(ph + de, 0, .01421 - .02),
                          a + along(de, .02308, .00916),  g + along(om + ep, .02 - .01421, 0),
                          a + along(ep, -.00449, -.01228)};
  for (int i = 0; i < 7; ++i)
    s.bodies.push_back({mass[i], {moment[i], moment[i], moment[i]}, {.position = centres[i]}});
  s.joints = {{kind::hinge, ground, 0, vec::Zero()},
              {kind::hinge, 0, 1, end_1},
              {kind::hinge, ground, 2, b},
              {kind::hinge, ground, 4, a},
              {kind::hinge, ground, 6, a},
              {kind::hinge, 4, 3, f},
              {kind::hinge, 6, 5, g},
              {kind::hinge, 1, 2, e},
              {kind::hinge, 1, 3, e},
              {kind::hinge, 1, 5, e}};
  s.springs = {{ground, 2, c, d, 4530, 0, .07785}};
  s.drives = {{0, {0, 0, .033}}};
  s.conservative = false;
  for (int i = 0; i < 7; ++i) s.probes.push_back({i, vec::UnitX(), true});
  s.error_is = "largest error of the direction of a body, rad";
  return s;
}

/// Five edges of a cube, the sixth is the ground; the axis of a hinge is normal to both its edges.
inline scene a04() {
  const vec p[6] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
  scene s{.name = "A04"};
  for (int i = 0; i < 5; ++i) {
    const vec way = p[i + 1] - p[i];
    s.bodies.push_back({1,
                        rod_inertia(1, 1, 0.1),
                        {(p[i] + p[i + 1]) / 2, turn::FromTwoVectors(vec::UnitX(), way)}});
  }
  for (int i = 0; i < 6; ++i) {
    const vec axis = (p[(i + 1) % 6] - p[i]).cross(p[i] - p[(i + 5) % 6]);
    s.joints.push_back({kind::hinge, i == 5 ? ground : i - 1, i == 5 ? 4 : i, p[i], axis});
  }
  s.probes = {{2, p[3]}};
  s.error_is = "largest distance of the corner P3 from the reference, m";
  return s;
}

/// Shaft, slider, two rods with a ball at the end of each; the coupler rods are springs.
inline scene a05() {
  scene s{.name = "A05"};
  const vec spin{0, 2 * pi, 0};
  const double rod = 0.3, ball = 5, slider = 3, offset = 0.05;
  const double m = rod + ball, centre = (rod * 0.5 + ball) / m;
  const vec thin = rod_inertia(rod, 1, 0.01);
  const double across =
      thin.y() + rod * (centre - 0.5) * (centre - 0.5) + ball * (1 - centre) * (1 - centre);
  s.bodies = {{rod, {thin.y(), thin.x(), thin.y()}, {.position = {0, 0.5, 0}, .spin = spin}},
              {slider, vec::Constant(slider * 0.01 / 6), {.position = {0, 0.5, 0}, .spin = spin}}};
  s.joints = {{kind::hinge, ground, 0, vec::Zero(), vec::UnitY()},
              {kind::slider, 0, 1, {0, 0.5, 0}, vec::UnitY()}};
  for (const double side : {1., -1.}) {
    const int index = static_cast<int>(s.bodies.size());
    const vec pin{side * offset, 1, 0};
    const vec way{side * std::cos(pi / 6), -0.5, 0};
    const vec at = pin + centre * way;
    s.bodies.push_back({m,
                        {thin.x(), across, across},
                        {at, turn::FromTwoVectors(vec::UnitX(), way), spin.cross(at), spin}});
    s.joints.push_back({kind::hinge, 0, index, pin, vec::UnitZ()});
    s.springs.push_back({1, index, {side * offset, 0.5, 0}, pin + 0.5 * way, 8e5, 4e4, 0.5});
  }
  s.conservative = false;
  s.probes = {{1, {0, 0.5, 0}}};
  s.error_is = "largest error of the height of the slider, m";
  return s;
}

/// Rods of 1 m and 1 kg hang from the origin; the last weighs 1,000 kg and is pushed by 1 m/s.
inline scene chain(int links) {
  scene s{.name = "chain_" + std::to_string(links), .duration = 1};
  const turn down = turn::FromTwoVectors(vec::UnitX(), -vec::UnitY());
  for (int i = 0; i < links; ++i) {
    const double m = i + 1 < links ? 1 : 1000;
    s.bodies.push_back({m, rod_inertia(m, 1, 0.1), {{0, -0.5 - i, 0}, down}});
    s.joints.push_back({kind::ball, i - 1, i, {0, -1. * i, 0}});
  }
  // The last link swings about its upper end, so the joints hold for the first velocities too.
  s.bodies.back().start.velocity = {1, 0, 0};
  s.bodies.back().start.spin = {0, 0, 2};
  s.error_is = "largest gap, link lengths";
  return s;
}

/// n x n bodies of 1 kg, neighbours joined half-way; the first row is joined to the ground.
inline scene grid(int n) {
  scene s{.name = "grid_" + std::to_string(n), .duration = 1};
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) {
      const int index = i * n + k;
      const vec at{i * 1., 0, k * 1.};
      s.bodies.push_back({1, vec::Constant(0.4 * 0.25 * 0.25), {.position = at}});
      s.joints.push_back({kind::ball, i ? index - n : ground, index, at - vec{0.5, 0, 0}});
      if (k) s.joints.push_back({kind::ball, index - 1, index, at - vec{0, 0, 0.5}});
    }
  s.error_is = "largest gap, distances of neighbours";
  return s;
}

/// Names of all scenes; "chain_250" is there for the growth of the time with the length.
inline std::vector<std::string> scene_names() {
  return {"A01", "A02_2", "A02_10",    "A02_40",     "A03",
          "A04", "A05",   "chain_250", "chain_1000", "grid_100"};
}

inline scene scene_of(const std::string& name) {
  const auto number = [&](const std::string& before) {
    return std::stoi(name.substr(before.size()));
  };
  if (name == "A01") return a01();
  if (begins(name, "A02_")) return a02(number("A02_"));
  if (name == "A03") return a03();
  if (name == "A04") return a04();
  if (name == "A05") return a05();
  if (begins(name, "chain_")) return chain(number("chain_"));
  if (begins(name, "grid_")) return grid(number("grid_"));
  throw std::invalid_argument("there is no scene '" + name + "'");
}

}  // namespace bench::joints
