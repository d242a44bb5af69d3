#pragma once
// A contact of bodies whose inertia is a multiple of 1 and whose contact normals pass through
// their centres: spheres, against each other or against something immovable.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "talus/core/math.hpp"
#include "talus/response/solver_state.hpp"

namespace talus::detail {

/// Whether the second body of a contact can move at all; global bodies cannot.
enum class partner { moving, immovable };

/// What friction adds to a contact of round bodies, and to a change of its impulse.
template <bool Friction>
struct round_friction {
  real arm_a = 0;  ///< distance of the contact point from the centre of a, b
  real arm_b = 0;
  real friction = 0;  ///< coefficient mu
  real inverse_wt = 0;
  vec3 rt{0, 0, 0};  ///< tangential impulse
};
template <>
struct round_friction<false> {};

template <bool Friction>
struct round_change {
  real n = 0;
  vec3 t{0, 0, 0};
};
template <>
struct round_change<false> {
  real n = 0;
};

/// The Delassus block of such a contact is diagonal: w_n = 1/m_a + 1/m_b along the normal and
/// w_t = w_n + arm_a^2/I_a + arm_b^2/I_b across it. So the exact local solution of Coulomb's law
/// needs no tangent basis and no tensor: r_n = max(0, r_n - (u_n - target)/w_n), and r_t - u_t/w_t
/// is clipped radially to mu r_n. Velocities are those of a relative to b, impulses act on a.
/// Without friction nothing tangential is stored or computed.
template <class Law, partner Partner>
struct round_contact : round_friction<Law::friction> {
  static constexpr bool paired = Partner == partner::moving;

  std::int32_t a = 0;
  std::int32_t b = -1;
  vec3 normal{0, 0, 1};  ///< from b to a
  real target = 0;       ///< least separating velocity after the step
  real push = 0;         ///< least separating rate of the correction
  real inverse_wn = 0;
  real rn = 0;      ///< normal impulse
  real pushed = 0;  ///< normal impulse of the correction

  using change = round_change<Law::friction>;

  /// Effective masses; `split_a` and `split_b` are the numbers of parts that the masses of a and b
  /// are divided into where several contacts are solved simultaneously (1 elsewhere).
  void weigh(const solver_state& s, real split_a, real split_b) {
    const solver_body& A = s.bodies[a];
    real wn = split_a * A.inverse_mass;
    if constexpr (paired) wn += split_b * s.bodies[b].inverse_mass;
    inverse_wn = 1 / wn;
    if constexpr (Law::friction) {
      real wt = wn + split_a * this->arm_a * this->arm_a * A.inverse_inertia;
      if constexpr (paired) wt += split_b * this->arm_b * this->arm_b * s.bodies[b].inverse_inertia;
      this->inverse_wt = 1 / wt;
    }
  }

  /// Starts from an impulse of the last step, turned into the present cone.
  void warm(const vec3& impulse) {
    rn = std::max(real{0}, normal.dot(impulse));
    if constexpr (Law::friction) {
      this->rt = impulse - normal.dot(impulse) * normal;
      clip();
    }
  }
  [[nodiscard]] vec3 impulse() const {
    if constexpr (Law::friction)
      return rn * normal + this->rt;
    else
      return rn * normal;
  }
  [[nodiscard]] change whole() const {
    if constexpr (Law::friction)
      return {rn, this->rt};
    else
      return {rn};
  }

  /// Solves this contact with all others held; the change is still to be applied.
  change relax(const solver_state& s) {
    const solver_body& A = s.bodies[a];
    vec3 u = A.v;
    if constexpr (paired) u -= s.bodies[b].v;
    const real un = normal.dot(u);
    change d;
    d.n = rn;
    rn = std::max(real{0}, rn - (un - target) * inverse_wn);
    d.n = rn - d.n;
    if constexpr (Law::friction) {
      vec3 spin = this->arm_a * A.w;
      if constexpr (paired) spin += this->arm_b * s.bodies[b].w;
      d.t = this->rt;
      this->rt -= this->inverse_wt * (u - un * normal + normal.cross(spin));
      clip();
      d.t = this->rt - d.t;
    }
    return d;
  }

  void apply(solver_state& s, const change& d) const {
    apply_to_a(s, d);
    if constexpr (paired) apply_to_b(s, d);
  }
  void apply_to_a(solver_state& s, const change& d) const {
    solver_body& A = s.bodies[a];
    if constexpr (Law::friction) {
      A.v += A.inverse_mass * (d.n * normal + d.t);
      A.w -= (this->arm_a * A.inverse_inertia) * normal.cross(d.t);
    } else {
      A.v += (A.inverse_mass * d.n) * normal;
    }
  }
  void apply_to_b(solver_state& s, const change& d) const {
    solver_body& B = s.bodies[b];
    if constexpr (Law::friction) {
      B.v -= B.inverse_mass * (d.n * normal + d.t);
      B.w -= (this->arm_b * B.inverse_inertia) * normal.cross(d.t);
    } else {
      B.v -= (B.inverse_mass * d.n) * normal;
    }
  }

  real relax_push(const solver_state& s) {
    real rate = normal.dot(s.shift[a]);
    if constexpr (paired) rate -= normal.dot(s.shift[b]);
    const real before = pushed;
    pushed = std::max(real{0}, pushed - (rate - push) * inverse_wn);
    return pushed - before;
  }
  void push_a(solver_state& s, real d) const {
    s.shift[a] += (d * s.bodies[a].inverse_mass) * normal;
  }
  void push_b(solver_state& s, real d) const {
    if constexpr (paired) s.shift[b] -= (d * s.bodies[b].inverse_mass) * normal;
  }

 private:
  void clip() {
    const real limit = this->friction * rn, square = this->rt.squaredNorm();
    if (square > limit * limit) this->rt *= limit / std::sqrt(square);
  }
};

}  // namespace talus::detail
