#pragma once
// A contact in which at least one body has an inertia tensor or a lever arm off the normal.
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/constraint/contact_bias.hpp"
#include "talus/constraint/contact_impact.hpp"
#include "talus/constraint/contact_manifold.hpp"
#include "talus/constraint/coulomb_block.hpp"
#include "talus/constraint/frame_around.hpp"
#include "talus/constraint/isotropic_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/law.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// Properties of one side of a contact that the solver takes from its shape.
enum class contact_side { scalar, tensor, immovable };

/// The impulse of a contact without friction: its normal component.
struct normal_impulse {
  real n = 0;

  [[nodiscard]] static normal_impulse Zero() { return {}; }
  [[nodiscard]] real& operator[](int) { return n; }
  [[nodiscard]] const real& operator[](int) const { return n; }
  [[nodiscard]] real dot(const normal_impulse& x) const { return n * x.n; }
  [[nodiscard]] real norm() const { return std::abs(n); }
  friend normal_impulse operator+(const normal_impulse& x, const normal_impulse& y) {
    return {x.n + y.n};
  }
  friend normal_impulse operator-(const normal_impulse& x, const normal_impulse& y) {
    return {x.n - y.n};
  }
  friend normal_impulse operator*(real s, const normal_impulse& x) { return {s * x.n}; }
};

/// The local problem of a general contact: its Delassus block in the frame of the contact, where an
/// impulse with friction has three components, without friction one.
template <class Cone>
struct local_problem {
  using impulse_type = vec3;

 protected:
  static vec3 seen(const vec3& normal, const vec3& v) {
    return seen_in(frame_around<real>(normal), v);
  }
  static vec3 unseen(const vec3& normal, const vec3& d) {
    return seen_from(frame_around<real>(normal), d);
  }
  /// The part of a relative velocity that the contact acts against.
  static const vec3& resisted(const vec3& u, const vec3&) { return u; }
  static real trace_of(const mat3& w, const vec3&) { return trace(w); }

  /// `w` is the block in the frame of the world.
  void set_block(const mat3& w, const vec3& normal) {
    const mat3 frame = frame_around<real>(normal);
    block_.set(frame * w * frame.transpose());
  }
  /// The impulse that satisfies the law if `r` leaves the velocity u, relative to the target.
  [[nodiscard]] vec3 solve(const vec3& r, const vec3& u, const vec3& normal, real target,
                           real mu) const {
    vec3 in_frame = seen(normal, u);
    in_frame[0] -= target;
    return block_.solve(r, in_frame, mu);
  }
  static void project(vec3& r, real mu) {
    vec3 t{0, r[1], r[2]};
    Cone::project(r[0], t, mu);
    r[1] = t[1], r[2] = t[2];
  }
  [[nodiscard]] real normal_mobility() const { return block_.nn; }
  [[nodiscard]] real inverse_normal_mobility() const { return block_.inverse_nn; }

 private:
  coulomb_block block_;
};
template <>
struct local_problem<frictionless> {
  using impulse_type = normal_impulse;

 protected:
  static normal_impulse seen(const vec3& normal, const vec3& v) { return {normal.dot(v)}; }
  static vec3 unseen(const vec3& normal, const normal_impulse& d) { return d.n * normal; }
  static vec3 resisted(const vec3& u, const vec3& normal) { return normal.dot(u) * normal; }
  static real trace_of(const mat3& w, const vec3& normal) { return normal.dot(w * normal); }

  void set_block(const mat3& w, const vec3& normal) { delassus_ = normal.dot(w * normal); }
  [[nodiscard]] normal_impulse solve(normal_impulse r, const vec3& u, const vec3& normal,
                                     real target, real mu) const {
    r.n -= (normal.dot(u) - target) * inverse_normal_mobility();
    project(r, mu);
    return r;
  }
  static void project(normal_impulse& r, real) { frictionless::project(r.n); }
  [[nodiscard]] real normal_mobility() const { return delassus_; }
  [[nodiscard]] real inverse_normal_mobility() const { return 1 / delassus_; }

 private:
  real delassus_ = 0;
};

/// The general contact: Delassus block in the frame (normal, tangent, tangent), solved exactly for
/// the Coulomb cone; without friction the frame is the normal alone. Velocities are those of a
/// relative to b, impulses act on a.
template <class Law, contact_side A, contact_side B, class Real = real>
struct general_contact
    : local_problem<typename Law::cone>,
      contact_bias<has_bias<Law>>,
      contact_impact<real, typename local_problem<typename Law::cone>::impulse_type,
                     Law::restitution> {
  using cone = typename Law::cone;
  using state = solver_state_of<Real>;  ///< velocities are Reals, all else is real
  static constexpr bool paired = B != contact_side::immovable;
  static constexpr bool manifolds = true;  ///< a pair of bodies has several such contacts
  /// If one of the bodies is isotropic, a pair has one contact. (In reduced precision contacts are
  /// solved one by one.)
  static constexpr bool swept_in_manifolds = cone::rows == 3 && A == contact_side::tensor &&
                                             B != contact_side::scalar &&
                                             std::is_same_v<Real, real>;
  static constexpr int rows = cone::rows;
  /// One by one in the order of the list: stacks converge much faster if the impulses propagate
  /// along them, and the local solution costs more than the waiting.
  static constexpr std::size_t streams = 1;
  using change = typename local_problem<cone>::impulse_type;  ///< in the frame

  // In this order, because vectors are read together with the number that follows them.
  vec3 normal{0, 0, 1};  ///< from b to a; the tangents are those of frame_around
  vec3 arm_a{0, 0, 0};   ///< from the centre of mass to the contact point
  vec3 arm_b{0, 0, 0};
  change r = change::Zero();  ///< impulse in the frame
  real target_velocity = 0;   ///< least separating velocity after the step
  real correction_rate =
      0;              ///< least separating rate of the correction; at rest and under load, the rate
  real friction = 0;  ///< coefficient mu
  real correction_impulse = 0;  ///< normal impulse of the correction
  std::int32_t a = 0;
  std::int32_t b = -1;

  void prepare(const state& s, real split_a, real split_b) {
    mat3 w = mobility<A>(s, a, arm_a, split_a);
    if constexpr (paired) w += mobility<B>(s, b, arm_b, split_b);
    this->set_block(w, normal);
  }
  /// Whether the two bodies and the normal are the same.
  [[nodiscard]] bool same_manifold(const general_contact& other) const {
    return a == other.a && b == other.b && normal == other.normal;
  }
  void load_impulse(const vec3& impulse) {
    r = this->seen(normal, impulse);
    this->project(r, friction);
  }
  /// Sets the impulse from a vector in the world, for a contact whose frame is known: all contacts
  /// of a manifold share the frame around the normal.
  void load_impulse(const vec3& impulse, const mat3& frame) requires(rows == 3) {
    r = seen_in(frame, impulse);
    this->project(r, friction);
  }
  [[nodiscard]] vec3 impulse() const { return this->unseen(normal, r); }
  [[nodiscard]] vec3 impulse(const mat3& frame) const requires(rows == 3) {
    return seen_from(frame, r);
  }
  [[nodiscard]] change impulse_in_frame() const { return r; }

  // Functions for solving several contacts as one problem; see stalled_islands.hpp.
  [[nodiscard]] mat3 axes() const { return frame_around<real>(normal); }
  [[nodiscard]] const vec3& lever_a() const { return arm_a; }
  [[nodiscard]] const vec3& lever_b() const { return arm_b; }
  [[nodiscard]] change since(const change& before) const { return r - before; }
  /// The change of velocity at the contact that a change of its impulse causes.
  [[nodiscard]] real speed_of(const change& d) const { return d.norm() * this->normal_mobility(); }
  /// Replaces the impulse, which may leave the cone for a while; the change is still to be applied.
  void set(const change& next) { r = next; }

  // Terms of the residual; see residual.hpp.
  [[nodiscard]] const vec3& axis() const { return normal; }
  [[nodiscard]] real mu() const { return rows == 3 ? friction : 0; }
  /// The velocity of a relative to b at the point of contact; without friction, only its normal
  /// component.
  [[nodiscard]] vec3 relative_velocity(const state& s) const {
    vec3 u = v_of(s.bodies[a]) + w_of(s.bodies[a]).cross(arm_a);
    if constexpr (paired) u -= v_of(s.bodies[b]) + w_of(s.bodies[b]).cross(arm_b);
    return this->resisted(u, normal);
  }
  /// Sum of the diagonal of the Delassus block, with undivided masses.
  [[nodiscard]] real delassus_trace(const state& s) const {
    mat3 w = mobility<A>(s, a, arm_a, 1);
    if constexpr (paired) w += mobility<B>(s, b, arm_b, 1);
    return this->trace_of(w, normal);
  }

  change relax(const state& s) {
    vec3 u = v_of(s.bodies[a]) + w_of(s.bodies[a]).cross(arm_a);
    if constexpr (paired) u -= v_of(s.bodies[b]) + w_of(s.bodies[b]).cross(arm_b);
    if constexpr (general_contact::biased) u -= this->bias;
    const change before = r;
    r = this->solve(r, u, normal, target_velocity, friction);
    return r - before;
  }
  void apply(state& s, const change& d) const {
    apply_to_a(s, d);
    if constexpr (paired) apply_to_b(s, d);
  }
  void apply_to_a(state& s, const change& d) const {
    const vec3 p = this->unseen(normal, d);
    s.bodies[a].v += in_scalar<Real>(vec3(s.bodies[a].inverse_mass * p));
    s.bodies[a].w += in_scalar<Real>(turn<A>(s, a, arm_a.cross(p)));
  }
  void apply_to_b(state& s, const change& d) const {
    const vec3 p = this->unseen(normal, d);
    s.bodies[b].v -= in_scalar<Real>(vec3(s.bodies[b].inverse_mass * p));
    s.bodies[b].w -= in_scalar<Real>(turn<B>(s, b, arm_b.cross(p)));
  }

  real relax_correction(const state& s) {
    const vec3 n = axis();
    real rate = n.dot(shift_at<A>(s, a, arm_a));
    if constexpr (paired) rate -= n.dot(shift_at<B>(s, b, arm_b));
    const real before = correction_impulse;
    const real next =
        correction_impulse - (rate - correction_rate) * this->inverse_normal_mobility();
    // Surfaces under load neither separate nor approach except by the position correction.
    correction_impulse = target_velocity == 0 && r[0] > 0 ? next : std::max(real{0}, next);
    return correction_impulse - before;
  }
  void correct_a(state& s, real d) const { correct_one<A>(s, a, arm_a, d); }
  void correct_b(state& s, real d) const {
    if constexpr (paired) correct_one<B>(s, b, arm_b, -d);
  }

 private:
  template <contact_side Side>
  static vec3 turn(const state& s, std::int32_t i, const vec3& moment) {
    if constexpr (Side == contact_side::tensor)
      return s.tensor(i) * moment;
    else
      return s.bodies[i].inverse_inertia * moment;
  }
  /// The displacement of the contact point by the correction; an isotropic body need not rotate for
  /// it.
  template <contact_side Side>
  static vec3 shift_at(const state& s, std::int32_t i, const vec3& arm) {
    vec3 rate = in_scalar<real>(s.shift[i].v);
    if constexpr (Side == contact_side::tensor) rate += s.turn[i - s.first_tensor].w.cross(arm);
    return rate;
  }
  template <contact_side Side>
  void correct_one(state& s, std::int32_t i, const vec3& arm, real d) const {
    const vec3 p = d * axis();
    s.shift[i].v += in_scalar<Real>(vec3(s.bodies[i].inverse_mass * p));
    if constexpr (Side == contact_side::tensor)
      s.turn[i - s.first_tensor].w += s.tensor(i) * arm.cross(p);
  }
  /// Velocity of the contact point of one body for a unit impulse there.
  template <contact_side Side>
  static mat3 mobility(const state& s, std::int32_t i, const vec3& arm, real split) {
    const mat3 x = cross_matrix(arm);
    mat3 turning;
    if constexpr (Side == contact_side::tensor)
      turning = x * s.tensor(i) * x;
    else
      turning = s.bodies[i].inverse_inertia * (x * x);
    return split * (diagonal_matrix<real>(s.bodies[i].inverse_mass) - turning);
  }
};

}  // namespace talus::detail
