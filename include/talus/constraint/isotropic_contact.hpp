#pragma once
// A contact of bodies whose inertia is a multiple of 1 and whose contact normals pass through their
// centres: spheres, against each other or against something immovable.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/constraint/contact_bias.hpp"
#include "talus/constraint/frame_around.hpp"
#include "talus/constraint/isotropic_blocks.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/law.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack_rows.hpp"

namespace talus::detail {

/// Whether the second body of a contact can move at all; global bodies cannot.
enum class partner { moving, immovable };

/// Friction data of a contact of isotropic bodies, and of a change of its impulse.
template <bool Friction, class Real = real>
struct round_friction {
  vector3<Real> rt{0, 0, 0};  ///< tangential impulse
  Real inverse_wt = 0;
  Real arm_a = 0;  ///< distance of the contact point from the centre of a, b
  Real arm_b = 0;
  Real friction = 0;  ///< coefficient mu
};
template <class Real>
struct round_friction<false, Real> {};

template <bool Friction, class Real>
struct isotropic_change {
  row_pack<Real> t{0, 0, 0, 0};
  Real n = 0;

  friend isotropic_change operator+(const isotropic_change& x, const isotropic_change& y) {
    return {x.t + y.t, x.n + y.n};
  }
  friend isotropic_change operator-(const isotropic_change& x, const isotropic_change& y) {
    return {x.t - y.t, x.n - y.n};
  }
  friend isotropic_change operator*(Real f, const isotropic_change& x) {
    return {f * x.t, f * x.n};
  }
  [[nodiscard]] Real dot(const isotropic_change& x) const {
    return n * x.n + sum_of_products(t, x.t);
  }
};
template <class Real>
struct isotropic_change<false, Real> {
  Real n = 0;

  friend isotropic_change operator+(const isotropic_change& x, const isotropic_change& y) {
    return {x.n + y.n};
  }
  friend isotropic_change operator-(const isotropic_change& x, const isotropic_change& y) {
    return {x.n - y.n};
  }
  friend isotropic_change operator*(Real f, const isotropic_change& x) { return {f * x.n}; }
  [[nodiscard]] Real dot(const isotropic_change& x) const { return n * x.n; }
};

/// The Delassus block of such a contact is diagonal: w_n = 1/m_a + 1/m_b along the normal and w_t =
/// w_n + arm_a^2/I_a + arm_b^2/I_b across it. So the exact local solution of Coulomb's law needs no
/// tangent basis and no tensor: r_n = max(0, r_n - (u_n - target)/w_n), and r_t - u_t/w_t is
/// clipped radially to mu r_n. Velocities are those of a relative to b, impulses act on a. Without
/// friction nothing tangential is stored or computed. Vectors are processed as rows of four, which
/// is why a number follows each of them in memory. Results for other code are of type real.
template <class Law, partner Partner, class Real = real>
struct isotropic_contact : round_friction<Law::friction, Real>, contact_bias<has_bias<Law>> {
  using number = Real;
  using state = solver_state_of<Real>;
  using row = row_pack<Real>;
  static constexpr bool paired = Partner == partner::moving;
  static constexpr int rows = Law::friction ? 3 : 1;  ///< of the Delassus operator
  /// Consecutive contacts in the list share a body, so that each would wait for the one before;
  /// contacts far apart do not, and the processor works on several at once.
  static constexpr std::size_t streams = 3;

  /// Smaller impulses count as zero.
  static constexpr Real tiny = std::is_same_v<Real, double> ? Real(1e-150) : Real(1e-19);
  using blocks = isotropic_blocks<isotropic_contact>;

  vector3<Real> normal{0, 0, 1};  ///< from b to a
  Real inverse_wn = 0;
  std::int32_t a = 0;
  std::int32_t b = -1;
  Real target_velocity = 0;  ///< least separating velocity after the step
  Real correction_rate =
      0;        ///< least separating rate of the correction; at rest and under load, the rate
  Real rn = 0;  ///< normal impulse
  Real correction_impulse = 0;  ///< normal impulse of the correction

  using change = isotropic_change<Law::friction, Real>;

  /// Effective masses; `split_a` and `split_b` are the numbers of parts into which the masses of a
  /// and b are divided if several contacts are solved simultaneously (else 1).
  void prepare(const state& s, Real split_a, Real split_b) {
    const body& A = s.bodies[a];
    Real wn = split_a * A.inverse_mass;
    if constexpr (paired) wn += split_b * s.bodies[b].inverse_mass;
    inverse_wn = 1 / wn;
    if constexpr (Law::friction) {
      Real wt = wn + split_a * this->arm_a * this->arm_a * A.inverse_inertia;
      if constexpr (paired) wt += split_b * this->arm_b * this->arm_b * s.bodies[b].inverse_inertia;
      this->inverse_wt = 1 / wt;
    }
  }

  /// Warm start from an impulse of the last step, projected into the present cone.
  void load_impulse(const vec3& kept) {
    const vector3<Real>& impulse = in_scalar<Real>(kept);
    rn = std::max(Real{0}, normal.dot(impulse));
    if constexpr (Law::friction) {
      this->rt = impulse - normal.dot(impulse) * normal;
      const Real limit = this->friction * rn, square = this->rt.squaredNorm();
      if (square > limit * limit) this->rt *= limit / std::sqrt(square);
    }
  }
  [[nodiscard]] vec3 impulse() const {
    if constexpr (Law::friction)
      return in_scalar<real>(vector3<Real>(rn * normal + this->rt));
    else
      return in_scalar<real>(vector3<Real>(rn * normal));
  }
  [[nodiscard]] change impulse_in_frame() const {
    if constexpr (Law::friction)
      return {tangent(), rn};
    else
      return {rn};
  }

  /// Replaces the impulse, which may leave the cone for a while; the change is still to be applied.
  void set(const change& r) {
    rn = r.n;
    if constexpr (Law::friction) this->rt = xyz(r.t);
  }

  // Terms of the residual; see residual.hpp.
  [[nodiscard]] decltype(auto) axis() const { return in_scalar<real>(normal); }
  [[nodiscard]] real mu() const {
    if constexpr (Law::friction)
      return this->friction;
    else
      return 0;
  }
  /// Of a against b at the point of contact; without friction its normal part alone.
  [[nodiscard]] vec3 relative_velocity(const state& s) const {
    vec3 u = v_of(s.bodies[a]);
    if constexpr (paired) u -= v_of(s.bodies[b]);
    const vec3& n = axis();
    if constexpr (Law::friction) {
      vec3 spin = this->arm_a * w_of(s.bodies[a]);
      if constexpr (paired) spin += this->arm_b * w_of(s.bodies[b]);
      return u + n.cross(spin);
    } else {
      return n.dot(u) * n;
    }
  }
  /// Sum of the diagonal of the Delassus block, with undivided masses.
  [[nodiscard]] real delassus_trace(const state& s) const {
    const body& A = s.bodies[a];
    real trace = rows * A.inverse_mass;
    if constexpr (paired) trace += rows * s.bodies[b].inverse_mass;
    if constexpr (Law::friction) {
      trace += 2 * this->arm_a * this->arm_a * A.inverse_inertia;
      if constexpr (paired) trace += 2 * this->arm_b * this->arm_b * s.bodies[b].inverse_inertia;
    }
    return trace;
  }

  // Functions for solving several contacts as one problem; see stalled_islands.hpp.
  [[nodiscard]] mat3 axes() const { return frame_around<real>(axis()); }
  [[nodiscard]] vec3 lever_a() const {
    if constexpr (Law::friction)
      return -this->arm_a * axis();
    else
      return {0, 0, 0};
  }
  [[nodiscard]] vec3 lever_b() const {
    if constexpr (Law::friction)
      return this->arm_b * axis();
    else
      return {0, 0, 0};
  }
  [[nodiscard]] change since(const change& before) const {
    if constexpr (Law::friction)
      return {tangent() - before.t, rn - before.n};
    else
      return {rn - before.n};
  }
  /// The change of velocity at the contact that a change of its impulse causes.
  [[nodiscard]] real speed_of(const change& d) const {
    Real square = d.n * d.n;
    if constexpr (Law::friction) square += sum_of_products(d.t, d.t);
    return std::sqrt(square) / inverse_wn;
  }

  /// Solves this contact with all others held; the change is still to be applied.
  change relax(const state& s) {
    const body& A = s.bodies[a];
    const row n = normal_row();
    row u = velocity(A);
    if constexpr (paired) u -= velocity(s.bodies[b]);
    if constexpr (isotropic_contact::biased) u -= bias_row();
    const Real un = sum_of_products(n, u);
    const Real before = rn;
    rn = std::max(Real{0}, rn - (un - target_velocity) * inverse_wn);
    if constexpr (Law::friction) {
      row spin = this->arm_a * spin_of(A);
      if constexpr (paired) spin += this->arm_b * spin_of(s.bodies[b]);
      const row old = load(row_of(*this, this->rt));
      row t = without_fourth(old - old[3] * (u - un * n + cross(n, spin)));
      // Without a branch: whether a contact slides is hard to predict.
      const Real limit = this->friction * rn;
      t *= limit / std::max({limit, std::sqrt(sum_of_products(t, t)), tiny});
      store(row_of(*this, this->rt), __builtin_shufflevector(t, old, 0, 1, 2, 7));
      return {t - without_fourth(old), rn - before};
    } else {
      return {rn - before};
    }
  }

  void apply(state& s, const change& d) const {
    apply_to_a(s, d);
    if constexpr (paired) apply_to_b(s, d);
  }
  void apply_to_a(state& s, const change& d) const {
    body& A = s.bodies[a];
    Real spin = 0;
    if constexpr (Law::friction) spin = this->arm_a * A.inverse_inertia;
    apply_impulse(A, d, A.inverse_mass, spin);
  }
  void apply_to_b(state& s, const change& d) const {
    body& B = s.bodies[b];
    Real spin = 0;
    if constexpr (Law::friction) spin = this->arm_b * B.inverse_inertia;
    apply_impulse(B, d, -B.inverse_mass, spin);
  }

  Real relax_correction(const state& s) {
    Real rate = normal.dot(s.shift[a].v);
    if constexpr (paired) rate -= normal.dot(s.shift[b].v);
    const Real before = correction_impulse;
    const Real next = correction_impulse - (rate - correction_rate) * inverse_wn;
    // Surfaces under load neither separate nor approach except by the position correction.
    correction_impulse = target_velocity == 0 && rn > 0 ? next : std::max(Real{0}, next);
    return correction_impulse - before;
  }
  void correct_a(state& s, Real d) const {
    s.shift[a].v += (d * s.bodies[a].inverse_mass) * normal;
  }
  void correct_b(state& s, Real d) const {
    if constexpr (paired) s.shift[b].v -= (d * s.bodies[b].inverse_mass) * normal;
  }

 private:
  using body = solver_body_of<Real>;

  [[nodiscard]] static row velocity(const body& x) { return load(row_of(x, x.v)); }
  [[nodiscard]] static row spin_of(const body& x) { return load(row_of(x, x.w)); }
  [[nodiscard]] row bias_row() const requires(isotropic_contact::biased) {
    const Real x = Real(this->bias[0]), y = Real(this->bias[1]), z = Real(this->bias[2]);
    return row{x, y, z, 0};
  }
  [[nodiscard]] row normal_row() const { return without_fourth(load(row_of(*this, normal))); }
  [[nodiscard]] row tangent() const { return without_fourth(load(row_of(*this, this->rt))); }

  void apply_impulse(body& x, const change& d, Real inverse_mass, Real spin) const {
    const row n = normal_row();
    if constexpr (Law::friction) {
      store(row_of(x, x.v), velocity(x) + inverse_mass * (d.n * n + d.t));
      store(row_of(x, x.w), spin_of(x) - spin * cross(n, d.t));
    } else {
      store(row_of(x, x.v), velocity(x) + (inverse_mass * d.n) * n);
    }
  }
};

}  // namespace talus::detail
