#pragma once
// The flight of a body in a frame with constant velocity and angular velocity.
#include <utility>

#include "talus/core/math.hpp"
#include "talus/shape/frame.hpp"

namespace talus::detail {

/// A flight relative to a rigid body that moves with the velocity `v` and rotates with the angular
/// velocity `w` about the point that is at `origin` at the time `since`, whose coordinates are
/// used. It has the members of a motion that time_of_impact() needs. The acceleration is an upper
/// bound until the time `until`, including the Coriolis and the centrifugal one; its direction has
/// no meaning.
template <class Flight>
struct moving_frame {
  vec3 acceleration, spin;
  static constexpr bool bounded = true;

  moving_frame(Flight flight, const vec3& origin, const vec3& v, const vec3& w, real until,
               real since = 0)
      : spin(flight.spin.norm() + w.norm(), 0, 0),
        flight_(std::move(flight)),
        origin_(origin),
        v_(v),
        w_(w),
        since_(since) {
    const real turning = w.norm(), pull = flight_.acceleration.norm();
    const real speed = vec3(flight_.velocity - v).norm() + until * pull;
    const real arm = vec3(flight_.position - (origin - since * v)).norm() + until * speed;
    acceleration = vec3(pull + turning * (2 * speed + turning * arm), 0, 0);
  }

  [[nodiscard]] vec3 place(real t) const { return origin_ + rotated(back(t), arm(t)); }
  [[nodiscard]] vec3 speed(real t) const {
    return rotated(back(t), vec3(flight_.speed(t) - v_ - w_.cross(arm(t))));
  }
  [[nodiscard]] pose at(real t) const {
    pose p = flight_.at(t);
    p.position = place(t);
    p.orientation = combined({{0, 0, 0}, back(t)}, {{0, 0, 0}, p.orientation}).orientation;
    return p;
  }

 private:
  [[nodiscard]] vec3 arm(real t) const { return flight_.place(t) - origin_ - (t - since_) * v_; }
  [[nodiscard]] quat back(real t) const {
    const real turning = w_.norm();
    return turning > 0 ? rotation(w_, -(t - since_) * turning) : quat(1, 0, 0, 0);
  }

  Flight flight_;
  vec3 origin_, v_, w_;
  real since_;
};

}  // namespace talus::detail
