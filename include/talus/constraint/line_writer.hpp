#pragma once
// Writes the rows of a joint for a step: kinds of joints say which, in the order of their slots.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/body/jointed_body.hpp"
#include "talus/constraint/joint_axis.hpp"
#include "talus/constraint/joint_geometry.hpp"
#include "talus/constraint/joint_line.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_trigonometry.hpp"

namespace talus::detail {

/// The coordinates of a joint: angles over any number of turns, and travels.
using joint_coordinates = std::array<real, 2>;

/// The largest distance of the centres of mass of two joined bodies, without position errors.
/// `Kind::room(anchors)` is how far the points of a joint may part; if it `roams` they part by its
/// coordinates, of which the first of two may be an angle.
template <class Kind>
[[nodiscard]] real distance_of(const typename Kind::anchors& x, const joint_coordinates& at) {
  real sum = x.frames.on_a.norm() + x.frames.on_b.norm();
  if constexpr (requires { Kind::room(x); }) sum += Kind::room(x);
  if constexpr (requires { Kind::roams; }) {
    sum += std::abs(at[1]);
    if constexpr (!requires { Kind::has_angle; }) sum += std::abs(at[0]);
  }
  return sum;
}

/// When rows are written: at the start of a step or in its middle, before its velocities are
/// solved.
struct joint_moment {
  real dt = 0;
  bool midway = false;    ///< positions are those of the middle of the step
  bool reflects = false;  ///< conditions hold for the mean of the velocities before and after
};

class line_writer {
 public:
  line_writer(std::span<joint_line> lines, joint_coordinates& coordinates,
              const joint_geometry& geometry, const jointed_body& a, const jointed_body& b,
              const joint_moment& when)
      : g(geometry), lines_(lines), coordinates_(coordinates), a_(a), b_(b), when_(when) {}

  const joint_geometry& g;  ///< where the joint is

  /// A condition on positions: the error is to be 0.
  void hold(joint_line x) {
    x.use = line_use::holds;
    if (when_.reflects) x.target = reflection(x);
    put(x);
  }
  /// The three conditions of a common point.
  void hold_point() {
    for (int k = 0; k < 3; ++k) hold(line_of_point(g, k));
  }
  /// The two conditions of a common third axis.
  void hold_axis() { hold(line_of_cosine(g, 2, 0)), hold(line_of_cosine(g, 2, 1)); }

  /// The condition that the angle of b about the third axis of a frame of the world is `ratio`
  /// times that of a about the third axis of another.
  void hold_ratio(const mat3& of_a, const mat3& of_b, real ratio) {
    const real a = whole_turns(angle_in(of_a, g.axes_a.col(0)));
    const real b = whole_turns(angle_in(of_b, g.axes_b.col(0)));
    joint_line x;
    x.moment_a = -ratio * of_a.col(2), x.moment_b = -of_b.col(2);
    x.error = b - ratio * a;
    hold(x);
  }

  /// The angle of b relative to a about their common third axis.
  void turn(const axis_rules& rules) {
    turn_about(g.axes_a.col(2), angle_in(g.axes_a, g.axes_b.col(0)), rules);
  }
  /// An angle that grows with the rotation of b relative to a about `axis`.
  void turn_about(const vec3& axis, real angle, const axis_rules& rules) {
    free(line_of_turn(axis), continued(angle), rules);
  }
  /// The travel of b from a along the third axis of a.
  void travel(const axis_rules& rules) {
    joint_line x = line_along(g, 2);
    free(x, x.error, rules);
  }
  /// By how much the distance of two points exceeds `length`.
  void stretch(real length, const axis_rules& rules) {
    joint_line x = line_of_elongation(g, length);
    free(x, x.error, rules);
  }
  /// The distance of two points, at most `length`.
  void reach(real length, real restitution) {
    joint_line x = line_of_distance(g, length);
    flip(x);
    put(limit(x, x.error, restitution));
  }

  /// A coordinate without rows.
  void note(real value) { coordinates_[axis_++] = value; }

  /// The rate of a row at the velocities of the bodies before the step.
  [[nodiscard]] real rate(const joint_line& x) const {
    return x.force.dot(a_.velocity - b_.velocity) + x.moment_a.dot(a_.spin) -
           x.moment_b.dot(b_.spin);
  }

 private:
  /// The angle of a direction about the third axis of a frame, from its first axis.
  [[nodiscard]] static real angle_in(const mat3& frame, const vec3& x) {
    return portable::atan2(x.dot(frame.col(1)), x.dot(frame.col(0)));
  }
  /// An angle of the next coordinate with all its turns. Computed again it has the same bits: a
  /// third rank gets the coordinates of the step under way.
  [[nodiscard]] real continued(real angle) const {
    return angle + 2 * pi * std::nearbyint((coordinates_[axis_] - angle) / (2 * pi));
  }
  /// Returns an angle of the next coordinate with all its turns, and stores it as that coordinate.
  real whole_turns(real angle) {
    const real value = continued(angle);
    note(value);
    return value;
  }
  void put(const joint_line& x) { lines_[next_++] = x; }
  void put_if(bool used, const joint_line& x) {
    if (used) lines_[next_] = x;
    ++next_;
  }
  static void flip(joint_line& x) {
    x.force = -x.force, x.moment_a = -x.moment_a, x.moment_b = -x.moment_b, x.error = -x.error;
  }

  /// The velocity after the step if the condition holds for the mean. Its rate before the step is
  /// that which the curvature of the motion causes within half a step; a larger one is an impact,
  /// or comes from the user, and ends.
  [[nodiscard]] real reflection(const joint_line& x) const {
    const real u = rate(x), spin = a_.spin.norm() + b_.spin.norm();
    const real size = x.force.norm();
    const real speed = size * (a_.velocity.norm() + b_.velocity.norm()) +
                       (x.moment_a.norm() + x.moment_b.norm() + size * g.gap.norm()) * spin;
    return std::abs(u) <= 2 * when_.dt * spin * speed ? -u : 0;
  }
  /// The time from the positions of the rows to the end of the step.
  [[nodiscard]] real left() const { return when_.midway ? when_.dt / 2 : when_.dt; }

  /// A gap that must not become negative.
  [[nodiscard]] joint_line limit(joint_line x, real gap, real restitution) const {
    x.use = line_use::limits;
    x.error = gap;
    x.least = 0;
    x.target = -std::max(gap, real(0)) / left();
    const real u = rate(x);
    if (restitution > 0 && u < 0 && gap + left() * u <= 0) x.target = -restitution * u;
    return x;
  }
  /// A coordinate with its value, and `x` as the row of its rate.
  void free(joint_line x, real value, const axis_rules& rules) {
    x.axis = static_cast<std::uint8_t>(axis_);
    note(value);
    x.error = 0;
    const joint_limits& l = rules.limits;
    if (l.lower == l.upper) {
      joint_line fixed = x;
      fixed.error = value - l.lower;
      hold(fixed), ++next_;
    } else {  // both, since a drive may take it from one to the other within a step
      joint_line from = x;
      flip(from);
      put_if(l.lower > -no_limit, limit(x, value - l.lower, l.restitution));
      put_if(l.upper < no_limit, limit(from, l.upper - value, l.restitution));
    }
    const joint_spring& k = rules.spring;
    if (k.stiffness > 0 || k.damping > 0)
      put(drive(x, line_use::spring, value, k.stiffness, k.damping, k.rest, 0));
    else
      ++next_;
    const force_motor& m = rules.motor;
    if (m.largest_force > 0) {
      joint_line by = x;
      by.use = line_use::motor, by.target = m.velocity;
      if (m.stiffness > 0 || m.damping > 0)
        by = drive(x, line_use::motor, value, m.stiffness, m.damping, m.position, m.velocity);
      bound(by, m.largest_force);
      put(by);
    } else {
      ++next_;
    }
    if (rules.friction > 0) {
      joint_line by = x;
      by.use = line_use::friction;
      bound(by, rules.friction);
      put(by);
    } else {
      ++next_;
    }
  }
  void bound(joint_line& x, real force) const {
    if (force >= no_limit) return;
    x.most = when_.dt * force, x.least = -x.most;
  }
  /// A spring and a damper, implicit: of the end of the step, or of the mean of its two ends.
  [[nodiscard]] joint_line drive(joint_line x, line_use use, real value, real stiffness,
                                 real damping, real rest, real velocity) const {
    x.use = use;
    const real k = when_.midway ? stiffness * when_.dt / 4 : stiffness * when_.dt;
    const real c = when_.midway ? damping / 2 : damping;
    real force = stiffness * (rest - value) + damping * velocity;
    if (when_.midway) force += (k - c) * rate(x);
    x.target = force / (k + c);
    x.compliance = 1 / (when_.dt * (k + c));
    return x;
  }

  std::span<joint_line> lines_;
  joint_coordinates& coordinates_;
  const jointed_body &a_, &b_;
  joint_moment when_;
  std::size_t next_ = 0, axis_ = 0;
};

}  // namespace talus::detail
