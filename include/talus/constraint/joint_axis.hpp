#pragma once
// The free coordinates of joints: limits, motors, springs and friction, as the user gives them and
// as a joint carries them. Angles are in radians, and those of the second body relative to the
// first, positive about the axis of the joint; travels are along it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// No limit of a coordinate.
inline constexpr real no_limit = std::numeric_limits<real>::max();

inline namespace joint_limits_have_lower_upper_and_restitution {

/// The range of an angle or a travel, relative to the pose in which the bodies are joined.
struct joint_limits {
  real lower = -no_limit;  ///< rad or length; below `upper`
  real upper = no_limit;   ///< rad or length
  real restitution = 0;    ///< of an impact on a limit, in [0, 1]
};

}  // namespace joint_limits_have_lower_upper_and_restitution

inline namespace a_torque_motor_has_velocity_largest_torque_position_stiffness_and_damping {

/// Drives an angle. Without stiffness and damping it holds `velocity`, with the torque that this
/// takes; with them its torque is stiffness (position - angle) + damping (velocity - its rate), of
/// the end of the step, so that any stiffness is stable. It has no effect if largest_torque is 0.
struct torque_motor {
  real velocity = 0;        ///< rad per unit of time
  real largest_torque = 0;  ///< of either sign
  real position = 0;        ///< rad
  real stiffness = 0;       ///< torque per rad
  real damping = 0;         ///< torque per angular velocity
};

}  // namespace a_torque_motor_has_velocity_largest_torque_position_stiffness_and_damping
inline namespace a_force_motor_has_velocity_largest_force_position_stiffness_and_damping {

/// Drives a travel, likewise.
struct force_motor {
  real velocity = 0;       ///< length per unit of time
  real largest_force = 0;  ///< of either sign
  real position = 0;       ///< length
  real stiffness = 0;      ///< force per length
  real damping = 0;        ///< force per velocity
};

}  // namespace a_force_motor_has_velocity_largest_force_position_stiffness_and_damping

inline namespace a_joint_spring_has_stiffness_damping_and_rest {

/// A spring and a damper on a coordinate, of the end of the step, so that any stiffness is stable.
struct joint_spring {
  real stiffness = 0;  ///< torque per rad, or force per length
  real damping = 0;    ///< torque per angular velocity, or force per velocity
  real rest = 0;       ///< the coordinate at which the spring is relaxed
};

}  // namespace a_joint_spring_has_stiffness_damping_and_rest

namespace detail {

/// All of it for one coordinate, as a joint carries it.
struct axis_rules {
  joint_limits limits;
  force_motor motor;  ///< or torque
  joint_spring spring;
  real friction = 0;  ///< the largest torque or force, by Coulomb's law
};
/// Rows of a coordinate: lower and upper limit, spring, motor, friction.
inline constexpr int rows_of_axis = 5;

[[nodiscard]] inline force_motor motor_of(const force_motor& m) { return m; }
[[nodiscard]] inline force_motor motor_of(const torque_motor& m) {
  return {m.velocity, m.largest_torque, m.position, m.stiffness, m.damping};
}
/// Infinity means no limit, too.
template <class Motor>
[[nodiscard]] axis_rules rules_of(const joint_limits& limits, const Motor& motor,
                                  const joint_spring& spring, real friction) {
  axis_rules x{limits, motor_of(motor), spring, friction};
  x.limits.lower = std::max(limits.lower, -no_limit);
  x.limits.upper = std::min(limits.upper, no_limit);
  x.motor.largest_force = std::min(x.motor.largest_force, no_limit);
  return x;
}

/// Throws invalid_argument for values without meaning; `joint` names the kind.
[[gnu::cold]] inline void require_motor(const char* joint, const force_motor& m) {
  if (!(m.largest_force >= 0))
    fail<std::invalid_argument>(
        "the largest torque or force of the motor of a {} must not be negative, but is {}", joint,
        text(m.largest_force));
  if (!(m.stiffness >= 0) || !(m.damping >= 0) || !std::isfinite(m.stiffness + m.damping))
    fail<std::invalid_argument>(
        "stiffness and damping of the motor of a {} must be finite and not negative, but are {} "
        "and {}",
        joint, text(m.stiffness), text(m.damping));
  if (!std::isfinite(m.velocity) || !std::isfinite(m.position))
    fail<std::invalid_argument>(
        "velocity and position of the motor of a {} must be finite, but are {} and {}", joint,
        text(m.velocity), text(m.position));
}
[[gnu::cold]] inline void require_rules(const char* joint, const axis_rules& x) {
  if (!(x.limits.lower <= x.limits.upper))
    fail<std::invalid_argument>(
        "the lower limit of a {} must not be above the upper one, but they are {} and {}", joint,
        text(x.limits.lower), text(x.limits.upper));
  if (!(x.limits.restitution >= 0 && x.limits.restitution <= 1))
    fail<std::invalid_argument>(
        "the restitution of the limits of a {} must be in [0, 1], but is {}", joint,
        text(x.limits.restitution));
  require_motor(joint, x.motor);
  if (!(x.spring.stiffness >= 0) || !(x.spring.damping >= 0) ||
      !std::isfinite(x.spring.stiffness + x.spring.damping + x.spring.rest))
    fail<std::invalid_argument>(
        "stiffness and damping of the spring of a {} must be finite and not negative, and its rest "
        "finite, but they are {}, {} and {}",
        joint, text(x.spring.stiffness), text(x.spring.damping), text(x.spring.rest));
  if (!(x.friction >= 0) || !std::isfinite(x.friction))
    fail<std::invalid_argument>("the friction of a {} must be finite and not negative, but is {}",
                                joint, text(x.friction));
}
[[gnu::cold]] inline void require_point(const char* joint, const char* which, const vec3& at) {
  if (!finite(at))
    fail<std::invalid_argument>("the {} of a {} must be finite, but is {}", which, joint, text(at));
}
[[gnu::cold]] inline void require_axis(const char* joint, const char* which, const vec3& axis) {
  require_point(joint, which, axis);
  if (axis == vec3(0, 0, 0))
    fail<std::invalid_argument>("the {} of a {} must have a length above 0, but is {}", which,
                                joint, text(axis));
}

}  // namespace detail
}  // namespace talus
