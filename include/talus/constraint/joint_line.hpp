#pragma once
// The rows of a joint, of any kind: linear conditions on the velocities of two bodies.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "talus/core/math.hpp"

namespace talus::detail {

inline constexpr real unbounded = std::numeric_limits<real>::infinity();

/// The larger of two values of at least 0. What is no number counts as the largest.
[[nodiscard]] inline real larger(real most, real x) {
  return x <= most ? most : x > most ? x : unbounded;
}

/// The role of a row: unused in this step, a condition on positions, or a force law of a free
/// coordinate: of a spring, a motor or friction. `limits` holds positions while it is reached.
enum class line_use : std::uint8_t { off, holds, limits, spring, motor, friction };
[[nodiscard]] constexpr bool drives(line_use use) { return use >= line_use::spring; }

/// One row: u = force . (v_a - v_b) + moment_a . w_a - moment_b . w_b is the velocity of the row,
/// and its impulse r acts with `force` and `moment_a` on a, and with the opposite of `force` and
/// `moment_b` on b, about the centres of mass. It holds that u + compliance r = target, where the
/// bounds of r allow it.
struct joint_line {
  vec3 force{0, 0, 0};
  vec3 moment_a{0, 0, 0}, moment_b{0, 0, 0};
  real error = 0;       ///< the position error, whose rate is u
  real target = 0;      ///< for u
  real compliance = 0;  ///< velocity per impulse
  real least = -unbounded, most = unbounded;
  line_use use = line_use::off;
  std::uint8_t axis = 0;  ///< of a force law: the number of its coordinate

  [[nodiscard]] bool bounded() const { return least > -unbounded || most < unbounded; }
};

/// Values of the rows of a joint: impulses, or velocities.
template <int N>
struct row_values {
  std::array<real, static_cast<std::size_t>(N)> at{};

  [[nodiscard]] real& operator[](std::ptrdiff_t k) { return at[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const real& operator[](std::ptrdiff_t k) const {
    return at[static_cast<std::size_t>(k)];
  }
  [[nodiscard]] real dot(const row_values& b) const {
    real sum = 0;
    for (int k = 0; k < N; ++k) sum += (*this)[k] * b[k];
    return sum;
  }
  [[nodiscard]] real squaredNorm() const { return dot(*this); }
  friend row_values operator+(const row_values& a, const row_values& b) {
    row_values c;
    for (int k = 0; k < N; ++k) c[k] = a[k] + b[k];
    return c;
  }
  friend row_values operator-(const row_values& a, const row_values& b) {
    row_values c;
    for (int k = 0; k < N; ++k) c[k] = a[k] - b[k];
    return c;
  }
  friend row_values operator*(real x, const row_values& a) {
    row_values c;
    for (int k = 0; k < N; ++k) c[k] = x * a[k];
    return c;
  }
  friend row_values operator*(const row_values& a, real x) { return x * a; }
  friend bool operator==(const row_values&, const row_values&) = default;
};

/// What drove a coordinate in the last step: impulses along it, and its mean rate.
struct axis_drive {
  real motor = 0, spring = 0, friction = 0, rate = 0;
};
/// What drove both coordinates that a joint may have.
using axis_drives = std::array<axis_drive, 2>;

/// A joint for a solver of many: its rows, and the impulses of these.
struct joint_view {
  std::int32_t a = 0, b = 0;  ///< in the solver's arrays
  int rows = 0;
  joint_line* lines = nullptr;
  real* impulse = nullptr;
  const real* earlier = nullptr;  ///< those of the last step
  const real* before = nullptr;   ///< velocities of the rows at its end
};

}  // namespace talus::detail
