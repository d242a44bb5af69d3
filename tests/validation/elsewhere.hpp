#pragma once
// Scenes of docs/validation/faults_elsewhere.md: one rank, SI units, a floor and some bodies.
#include <cmath>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/world/world.hpp>

#include "record.hpp"

namespace talus::validation {

constexpr real earth = 9.81, degree = pi / 180;

template <class Scenario>
struct elsewhere {
  serial::link link;
  world<Scenario> w{link};
  real dt;

  explicit elsewhere(const material& m, real weight = earth, real step = 1.0 / 240) : dt(step) {
    w.material(m);
    w.gravity({0, 0, -weight});
  }
  /// A plane through the origin that falls by `slope` along `down`.
  elsewhere& floor(real slope = 0, const vec3& down = {1, 0, 0}) {
    const vec3 n = std::sin(slope) * down.normalized() + vec3(0, 0, std::cos(slope));
    w.global([&](auto& s) { s.add(plane{.normal = n}, {}); });
    return *this;
  }
  template <class Shape>
  handle<Shape> wall(const Shape& shape, const vec3& at, const quat& q = {1, 0, 0, 0}) {
    handle<Shape> h;
    w.global(
        [&](auto& s) { h = s.add(body<Shape>{.shape = shape, .position = at, .orientation = q}); });
    return h;
  }
  template <class Shape>
  handle<Shape> add(const Shape& shape, const vec3& at, const vec3& v = {0, 0, 0},
                    const quat& q = {1, 0, 0, 0}, const vec3& spin = {0, 0, 0}) {
    return w.add(body<Shape>{
        .shape = shape, .position = at, .velocity = v, .angular_velocity = spin, .orientation = q});
  }
  void run(real time) {
    for (int k = 0, n = static_cast<int>(std::lround(time / dt)); k < n; ++k) w.step(dt);
  }
  /// The largest value of f() after each step.
  template <class F>
  real most(real time, F&& f) {
    real largest = -1e300;
    for (int k = 0, n = static_cast<int>(std::lround(time / dt)); k < n; ++k) {
      w.step(dt);
      largest = std::max<real>(largest, f());
    }
    return largest;
  }
  real energy() {
    const auto m = measure_motion(w);
    return m.kinetic_energy + m.potential_energy;
  }
};

/// The component of a velocity down a slope along x.
inline real down(const vec3& v, real slope) {
  return std::cos(slope) * v[0] - std::sin(slope) * v[2];
}

}  // namespace talus::validation
