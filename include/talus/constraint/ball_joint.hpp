#pragma once
// A ball joint: one point of a body stays at one point of another, and both turn freely about it.
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "talus/body/jointed_body.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"

namespace talus {

namespace detail {
template <class State>
struct ball_joint_row;
}

/// Holds a point of one body at a point of another: a spherical joint. Its impulse is a vector that
/// acts at that point.
struct ball_joint final {
  using talus_part_of = roles::joints;
  static constexpr const char* name = "ball_joint";

  vec3 at{0, 0, 0};  ///< the common point, in the world, when the bodies are joined

  /// Throws invalid_argument unless the point is finite.
  void validate() const {
    if (!detail::finite(at))
      detail::fail<std::invalid_argument>("the point of a ball joint must be finite, but is {}",
                                          detail::text(at));
  }

  /// The point in the frames of both bodies.
  struct anchors {
    vec3 on_a{0, 0, 0}, on_b{0, 0, 0};
  };
  [[nodiscard]] anchors fix(const pose& a, const pose& b) const {
    return {a.to_body(at), b.to_body(at)};
  }
  [[nodiscard]] static real distance(const anchors& x) { return x.on_a.norm() + x.on_b.norm(); }

  template <class State>
  using row = detail::ball_joint_row<State>;
};

namespace detail {

/// Three rows: the relative velocity of the two points is zero. Impulses act on a, in the world.
template <class State>
struct ball_joint_row {
  using state = State;
  using number = typename State::number;
  using change = vec3;
  using anchors = ball_joint::anchors;
  static constexpr bool paired = true;
  static constexpr int rows = 3;

  vec3 arm_a{0, 0, 0}, arm_b{0, 0, 0};  ///< from the centres of mass to the point
  vec3 r{0, 0, 0};                      ///< impulse
  vec3 correction_rate{0, 0, 0};        ///< of the points, which removes the position error
  vec3 correction_impulse{0, 0, 0};
  mat3 mass = mat3::Zero();             ///< effective mass: the inverse of the Delassus block
  mat3 correction_mass = mat3::Zero();  ///< the same for the correction
  std::int32_t a = 0, b = 0;

  /// The points of the two bodies part by the rotation of the arms in a step, which velocities at
  /// its start do not see: to second order by dt^2/2 w x (w x arm). The correction removes that in
  /// advance, and all of the error that is there.
  void place(const anchors& x, const jointed_body& on_a, const jointed_body& on_b, real dt) {
    arm_a = rotated(on_a.at.orientation, x.on_a);
    arm_b = rotated(on_b.at.orientation, x.on_b);
    const vec3 gap = (on_a.at.position - on_b.at.position) + (arm_a - arm_b);
    const vec3 bend =
        on_a.spin.cross(on_a.spin.cross(arm_a)) - on_b.spin.cross(on_b.spin.cross(arm_b));
    correction_rate = (real(-1) / dt) * gap - (real(0.5) * dt) * bend;
  }

  void prepare(const state& s, real split_a, real split_b) {
    mass = (mobility(s, a, arm_a, split_a) + mobility(s, b, arm_b, split_b)).inverse();
    correction_mass =
        (correction_mobility(s, a, arm_a, split_a) + correction_mobility(s, b, arm_b, split_b))
            .inverse();
  }
  change relax(const state& s) {
    const vec3 d = -(mass * relative_velocity(s));
    r += d;
    return d;
  }
  void apply(state& s, const change& d) const { apply_to_a(s, d), apply_to_b(s, d); }
  void apply_to_a(state& s, const change& d) const { push(s, a, arm_a, d); }
  void apply_to_b(state& s, const change& d) const { push(s, b, arm_b, -d); }

  [[nodiscard]] const change& impulse_in_frame() const { return r; }
  [[nodiscard]] change since(const change& before) const { return r - before; }
  void set(const change& next) { r = next; }
  [[nodiscard]] wrench on_a() const { return {r, arm_a.cross(r)}; }
  [[nodiscard]] wrench on_b() const { return {-r, -arm_b.cross(r)}; }

  /// Of a against b at the point.
  [[nodiscard]] vec3 relative_velocity(const state& s) const {
    return velocity(s, a, arm_a) - velocity(s, b, arm_b);
  }
  [[nodiscard]] real delassus_trace(const state& s) const {
    return trace(mobility(s, a, arm_a, 1)) + trace(mobility(s, b, arm_b, 1));
  }
  [[nodiscard]] real speed_of(const change& d) const { return (mass.inverse() * d).norm(); }

  vec3 relax_correction(const state& s) {
    const vec3 rate = shift(s, a, arm_a) - shift(s, b, arm_b);
    const vec3 d = correction_mass * (correction_rate - rate);
    correction_impulse += d;
    return d;
  }
  void correct_a(state& s, const vec3& d) const { correct(s, a, arm_a, d); }
  void correct_b(state& s, const vec3& d) const { correct(s, b, arm_b, -d); }

 private:
  static bool has_tensor(const state& s, std::int32_t i) {
    return s.has_tensor(static_cast<std::size_t>(i));
  }
  static const auto& body(const state& s, std::int32_t i) {
    return s.bodies[static_cast<std::size_t>(i)];
  }
  static const mat3& tensor(const state& s, std::int32_t i) {
    return s.tensor(static_cast<std::size_t>(i));
  }
  static vec3 velocity(const state& s, std::int32_t i, const vec3& arm) {
    const auto& x = body(s, i);
    return in_scalar<real>(x.v) + in_scalar<real>(x.w).cross(arm);
  }
  static void push(state& s, std::int32_t i, const vec3& arm, const vec3& p) {
    auto& x = s.bodies[static_cast<std::size_t>(i)];
    const vec3 moment = arm.cross(p);
    const vec3 dw =
        has_tensor(s, i) ? tensor(s, i) * moment : vec3(real(x.inverse_inertia) * moment);
    x.v += in_scalar<number>(vec3(real(x.inverse_mass) * p));
    x.w += in_scalar<number>(dw);
  }
  /// The velocity of the point for a unit impulse there.
  static mat3 mobility(const state& s, std::int32_t i, const vec3& arm, real split) {
    const auto& x = body(s, i);
    const mat3 lever = cross_matrix(arm);
    const mat3 turning = has_tensor(s, i) ? lever * tensor(s, i) * lever
                                          : mat3(real(x.inverse_inertia) * (lever * lever));
    return split * (diagonal_matrix<real>(real(x.inverse_mass)) - turning);
  }
  // The correction moves isotropic bodies without turning them.
  static mat3 correction_mobility(const state& s, std::int32_t i, const vec3& arm, real split) {
    if (has_tensor(s, i)) return mobility(s, i, arm, split);
    return split * diagonal_matrix<real>(real(body(s, i).inverse_mass));
  }
  static vec3 shift(const state& s, std::int32_t i, const vec3& arm) {
    const auto k = static_cast<std::size_t>(i);
    vec3 rate = in_scalar<real>(s.shift[k].v);
    if (has_tensor(s, i)) rate += s.turn[k - s.first_tensor].w.cross(arm);
    return rate;
  }
  static void correct(state& s, std::int32_t i, const vec3& arm, const vec3& p) {
    const auto k = static_cast<std::size_t>(i);
    s.shift[k].v += in_scalar<number>(vec3(real(body(s, i).inverse_mass) * p));
    if (has_tensor(s, i)) s.turn[k - s.first_tensor].w += tensor(s, i) * arm.cross(p);
  }
};

}  // namespace detail
}  // namespace talus
