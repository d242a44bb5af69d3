#pragma once
// Prescribed motion of bodies: motions as functions of time, for world.drive. A motion is any
// function of the time of the world that returns one of the three values below. With the alias
// behind each type clang, too, shows the namespace that lists its fields.
#include <cmath>

#include "talus/core/math.hpp"
#include "talus/core/portable_trigonometry.hpp"

namespace talus {

inline namespace a_rigid_displacement_has_shift_turn_and_about {

/// Positions of the points of a body at a time: x goes to about + turn (x - about) + shift, where x
/// is the position when the body was driven. A motion that returns it has no drift at all: the pose
/// depends on the time alone. At the time of the call it must be zero.
struct rigid_displacement {
  vec3 shift{0, 0, 0};    ///< length
  quat turn{1, 0, 0, 0};  ///< a unit quaternion
  vec3 about{0, 0, 0};    ///< the fixed point of `turn`
};

}  // namespace a_rigid_displacement_has_shift_turn_and_about
using rigid_displacement = a_rigid_displacement_has_shift_turn_and_about::rigid_displacement;

inline namespace a_rigid_velocity_has_velocity_angular_velocity_and_about {

/// Velocities of the points of a body at a time: velocity + angular_velocity x (x - about). A
/// motion that returns it is integrated step by step, from its value at the middle of each step: of
/// second order in dt, and exact if it is constant.
struct rigid_velocity {
  vec3 velocity{0, 0, 0};          ///< length over time
  vec3 angular_velocity{0, 0, 0};  ///< radians over time
  vec3 about{0, 0, 0};             ///< a point of the axis
};

}  // namespace a_rigid_velocity_has_velocity_angular_velocity_and_about
using rigid_velocity = a_rigid_velocity_has_velocity_angular_velocity_and_about::rigid_velocity;

inline namespace a_surface_velocity_has_velocity_angular_velocity_and_about {

/// Velocities of the points of a surface that moves within itself while its body stays, as a
/// conveyor belt does: velocity + angular_velocity x (x - about).
struct surface_velocity {
  vec3 velocity{0, 0, 0};          ///< length over time
  vec3 angular_velocity{0, 0, 0};  ///< radians over time
  vec3 about{0, 0, 0};             ///< a point of the axis
};

}  // namespace a_surface_velocity_has_velocity_angular_velocity_and_about
using surface_velocity =
    a_surface_velocity_has_velocity_angular_velocity_and_about::surface_velocity;

// The motions below count the time from the call of world.drive.

inline namespace an_oscillation_has_amplitude_frequency_and_phase {

/// Motion of a shaker: to and fro by `amplitude` sin(2 pi frequency t + phase), minus its value at
/// t = 0, so that it starts at the present position.
struct oscillation {
  vec3 amplitude{0, 0, 0};  ///< direction and half the stroke (length)
  real frequency = 1;       ///< cycles per unit of time
  real phase = 0;           ///< radians; pi/2 begins at the end of the stroke, without velocity

  /// Pose of the body at the time t.
  [[nodiscard]] rigid_displacement operator()(real t) const {
    const real now = portable::sin(2 * pi * frequency * t + phase);
    return {.shift = (now - portable::sin(phase)) * amplitude};
  }
};

}  // namespace an_oscillation_has_amplitude_frequency_and_phase
using oscillation = an_oscillation_has_amplitude_frequency_and_phase::oscillation;

inline namespace a_turning_has_about_axis_and_speed {

/// Motion of a drum or a mixer: about an axis through a point, at constant speed. In a step it may
/// rotate by less than half a turn.
struct turning {
  vec3 about{0, 0, 0};  ///< any point of the axis
  vec3 axis{0, 0, 1};   ///< any length but zero
  real speed = 0;       ///< radians per unit of time

  /// Pose of the body at the time t.
  [[nodiscard]] rigid_displacement operator()(real t) const {
    return {.turn = rotation(axis, speed * t), .about = about};
  }
};

}  // namespace a_turning_has_about_axis_and_speed
using turning = a_turning_has_about_axis_and_speed::turning;

inline namespace a_gliding_has_velocity {

/// Motion along a line, at constant velocity.
struct gliding {
  vec3 velocity{0, 0, 0};  ///< length over time

  /// Pose of the body at the time t.
  [[nodiscard]] rigid_displacement operator()(real t) const { return {.shift = t * velocity}; }
};

}  // namespace a_gliding_has_velocity
using gliding = a_gliding_has_velocity::gliding;

inline namespace a_belt_has_velocity {

/// A belt: the surface moves, and the body stays.
struct belt {
  vec3 velocity{0, 0, 0};  ///< length over time

  /// The velocity of the surface at any time.
  [[nodiscard]] surface_velocity operator()(real) const { return {.velocity = velocity}; }
};

}  // namespace a_belt_has_velocity
using belt = a_belt_has_velocity::belt;

}  // namespace talus
