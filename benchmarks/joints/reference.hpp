#pragma once
// Reference values of the probes at equal intervals of time, the last at the end of a scene. Scenes
// of few coordinates are integrated in those, the others by dae.hpp.
#include <array>
#include <cmath>
#include <numbers>

#include "dae.hpp"
#include "scenes.hpp"

namespace bench::joints {

constexpr int samples = 10;

/// A step of the classical Runge-Kutta method.
template <class Y, class F>
Y runge_kutta(const Y& y, double h, const F& slope) {
  const Y a = slope(y), b = slope(Y(y + h / 2 * a)), c = slope(Y(y + h / 2 * b)),
          d = slope(Y(y + h * c));
  return y + h / 6 * (a + 2 * b + 2 * c + d);
}

/// Angle and rate after time t of an angle with the acceleration rate * sin(angle).
inline Eigen::Vector2d swing(Eigen::Vector2d y, double rate, double t) {
  const int steps = static_cast<int>(std::lround(t / 2e-5));
  for (int i = 0; i < steps; ++i)
    y = runge_kutta(y, t / steps, [&](const Eigen::Vector2d& z) -> Eigen::Vector2d {
      return {z[1], rate * std::sin(z[0])};
    });
  return y;
}

/// Angle of the links from the vertical, and its rate, of n four-bar windows.
inline Eigen::Vector2d four_bars(int n, double t) {
  return swing({0, 1}, 9.81 * ((n + 1) / 2. + n) / ((n + 1) / 3. + n), t);
}

/// Rates of A05 in the angle of the shaft, the height of the slider and the angle of the rods below
/// the horizontal, which is the same for both rods.
using governor = Eigen::Matrix<double, 6, 1>;  // angle, height, rod; their rates

inline governor governor_slope(const scene& s, const governor& y) {
  const double offset = 0.05, g = 9.81;
  const body &shaft = s.bodies[0], &slider = s.bodies[1], &rod = s.bodies[2];
  const double c = (rod.start.position - vec{offset, 1, 0}).norm();
  const double along = rod.inertia.x(), across = rod.inertia.y();
  const double height = y[1], a = y[2], w = y[3], ca = std::cos(a), sa = std::sin(a);
  // Moment of both rods about the axis of the shaft, and its derivative by the angle of the rods.
  const double out = offset + c * ca;
  const double moment = shaft.inertia.y() + slider.inertia.y() +
                        2 * (rod.mass * out * out + across * ca * ca + along * sa * sa);
  const double change = 2 * (-2 * rod.mass * out * c * sa + 2 * (along - across) * sa * ca);
  // Spring from the slider to the middle of the rod.
  const double x = 0.5 * ca, z = 1 - 0.5 * sa - height, length = std::hypot(x, z);
  const double dx = -0.5 * sa * y[5], dz = -0.5 * ca * y[5] - y[4];
  const spring& k = s.springs[0];
  const double pull = k.stiffness * (length - k.rest) + k.damping * (x * dx + z * dz) / length;
  const double by_height = -z / length, by_angle = (x * -0.5 * sa + z * -0.5 * ca) / length;
  governor d;
  d << y.tail<3>(), -change * y[5] * w / moment, -g - 2 * pull * by_height / slider.mass,
      (change * w * w / 4 + rod.mass * g * c * ca - pull * by_angle) / (rod.mass * c * c + across);
  return d;
}

/// Values of the probes of a scene at the samples; empty for scenes without probes.
inline std::vector<std::vector<double>> reference(const scene& s, double step = 0) {
  std::vector<std::vector<double>> list;
  if (s.probes.empty()) return list;
  const double every = s.duration / samples;
  if (s.name == "A01") {
    Eigen::Vector2d y{-std::numbers::pi / 2, 0};  // from the lowest position
    for (int i = 0; i < samples; ++i) {
      y = swing(y, -9.81 / (1 + pendulum_inertia), every);
      list.push_back({std::sin(y[0]), -std::cos(y[0]), 0});
    }
  } else if (s.name.starts_with("A02_")) {
    const int n = static_cast<int>(s.bodies.size() - 1) / 2;
    for (int i = 1; i <= samples; ++i) {
      const Eigen::Vector2d y = four_bars(n, every * i);
      list.push_back({std::sin(y[0]), std::cos(y[0]), 0});
    }
  } else if (s.name == "A05") {
    const double h = step > 0 ? step : 5e-6;
    governor y;
    y << 0, 0.5, std::numbers::pi / 6, 2 * std::numbers::pi, 0, 0;
    for (int i = 0; i < samples; ++i) {
      const int steps = static_cast<int>(std::lround(every / h));
      for (int k = 0; k < steps; ++k)
        y = runge_kutta(y, every / steps, [&](const governor& z) { return governor_slope(s, z); });
      list.push_back({0, y[1], 0});
    }
  } else {
    const double h = step > 0 ? step : s.duration / 1000;
    dae exact(s);
    for (int i = 0; i < samples; ++i) {
      const int steps = static_cast<int>(std::lround(every / h));
      for (int k = 0; k < steps; ++k) exact.step(every / steps);
      list.push_back(values(s, exact.states()));
    }
  }
  return list;
}

}  // namespace bench::joints
