#pragma once
// Refers to a joint of a world.
#include <cstddef>
#include <stdexcept>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/refused_fields.hpp"
#include "talus/state/joint_table.hpp"

namespace talus {

namespace detail {

inline constexpr sentence motor_by_name =
    "set_motor of a joint takes torque_motor{...} for an angle, or force_motor{...} for a travel, "
    "with the fields velocity, largest_torque or largest_force, position, stiffness and damping, "
    "in this order";
template <sentence S>
struct no_motor_by_name {
  static_assert(
      unrefused<S>,
      "set_motor of a joint takes torque_motor{...} for an angle, or force_motor{...} for a "
      "travel, with the fields velocity, largest_torque or largest_force, position, stiffness and "
      "damping, in this order");
};

}  // namespace detail

template <class Scenario>
class world;

/// What a motor, a spring (with its damper) or friction did in the last step.
struct joint_load {
  /// Mean torque about the axis of the joint, or force along it, on its second body; the opposite
  /// on its first. Positive if it drives the angle or travel upwards.
  double load = 0;
  /// Mean power that it gives to the bodies, load times the mean of the rates before and after the
  /// step; negative if it takes energy from them.
  double power = 0;
};
/// The loads on an angle or a travel.
struct joint_loads {
  joint_load motor, spring, friction;
};

/// The frame of the world as a body of a joint: `world.join(world_frame, door, hinge{...})`.
struct world_frame_t final {};
inline constexpr world_frame_t world_frame{};

/// A joint that world.join(...) made; a value on all ranks, as long as its world. The ranks that
/// own one of its bodies hold the joint: only these have its impulse.
template <class Scenario, class Kind>
class joint_handle {
 public:
  joint_handle(world<Scenario>& w, const detail::joint_key& key) : world_(&w), key_(key) {}

  /// Whether this rank holds the joint: it owns one of the bodies that can move, and the joint was
  /// not released.
  [[nodiscard]] bool known() const { return world_->find_joint(*this) != nullptr; }
  /// The impulse of the joint on its first body in the last step, in the world. Throws
  /// invalid_argument on a rank that does not hold the joint.
  [[nodiscard]] vec3 impulse() const { return record().load.impulse; }
  /// The angular impulse likewise, about the point of the joint.
  [[nodiscard]] vec3 angular_impulse() const { return record().load.moment; }
  /// The mean force on its first body in the last step: the impulse over the length of the step, 0
  /// before the first. Throws as impulse().
  [[nodiscard]] vec3 force() const { return rate() * impulse(); }
  /// The mean torque likewise, about the point of the joint.
  [[nodiscard]] vec3 torque() const { return rate() * angular_impulse(); }
  /// The angle of the second body relative to the first, in radians, over any number of turns: when
  /// the rows of the last step were computed, 0 before the first. Throws as impulse().
  [[nodiscard]] real angle() const requires(Kind::has_angle) { return record().coordinates[0]; }
  /// The travel of the second body along the axis, likewise.
  [[nodiscard]] real travel() const requires(Kind::has_travel) {
    if constexpr (requires { Kind::has_angle; }) return record().coordinates[1];
    return record().coordinates[0];
  }
  /// The loads of the motor, the spring and the friction of a coordinate in the last step, 0 before
  /// the first. Of two coordinates (two angles, or an angle and a travel) the first has number 0.
  /// Throws as impulse().
  [[nodiscard]] joint_loads loads(std::size_t coordinate = 0) const
      requires(detail::has_axes<Kind>) {
    const detail::axis_drive& x = record().drives.at(coordinate);
    const auto load = [&](real impulse) {
      const double mean = rate() * impulse;
      return joint_load{mean, mean * x.rate};
    };
    return {load(x.motor), load(x.spring), load(x.friction)};
  }
  /// Changes the motor, from the next step on. All ranks call it alike. Throws invalid_argument for
  /// values without meaning, and runtime_error in an exclusive section.
  template <class Motor>
  void set_motor(const Motor& motor) requires requires(typename Kind::anchors& x) {
    Kind::drive(x, motor);
  }
  { world_->set_motor(*this, motor); }
  /// Refuses a motor without its name, and other fields.
  template <detail::sentence Fields = detail::motor_by_name>
  detail::no_motor_by_name<Fields> set_motor(...) TALUS_REFUSED;
  /// Removes the joint. All ranks call it alike; throws runtime_error in an exclusive section.
  void release() { world_->release(*this); }

  /// The bodies, in the order in which they were joined, and the number of the joint.
  [[nodiscard]] const detail::joint_key& key() const { return key_; }

 private:
  [[nodiscard]] const detail::joint_record<Kind>& record() const {
    if (const auto* r = world_->find_joint(*this)) return *r;
    detail::fail<std::invalid_argument>(
        "rank {} does not hold this {}: it was released, or its bodies live on other ranks (ask "
        "known())",
        world_->rank(), Kind::name);
  }
  [[nodiscard]] real rate() const {
    const real dt = world_->state_.dt;
    return dt > 0 ? 1 / dt : real(0);
  }

  world<Scenario>* world_;
  detail::joint_key key_;
};

}  // namespace talus
