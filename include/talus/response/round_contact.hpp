#pragma once
// A contact of bodies whose inertia is a multiple of 1 and whose contact normals pass through
// their centres: spheres, against each other or against something immovable.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/core/math.hpp"
#include "talus/core/quad.hpp"
#include "talus/response/frame_around.hpp"
#include "talus/response/round_blocks.hpp"
#include "talus/response/solver_state.hpp"

namespace talus::detail {

template <class Contact>
class round_blocks;

/// Whether the second body of a contact can move at all; global bodies cannot.
enum class partner { moving, immovable };

/// What friction adds to a contact of round bodies, and to a change of its impulse.
template <bool Friction>
struct round_friction {
  vec3 rt{0, 0, 0};  ///< tangential impulse
  real inverse_wt = 0;
  real arm_a = 0;  ///< distance of the contact point from the centre of a, b
  real arm_b = 0;
  real friction = 0;  ///< coefficient mu
};
template <>
struct round_friction<false> {};

template <bool Friction>
struct round_change {
  quad t{0, 0, 0, 0};
  real n = 0;

  friend round_change operator+(const round_change& x, const round_change& y) {
    return {x.t + y.t, x.n + y.n};
  }
  friend round_change operator-(const round_change& x, const round_change& y) {
    return {x.t - y.t, x.n - y.n};
  }
  friend round_change operator*(real f, const round_change& x) { return {f * x.t, f * x.n}; }
  [[nodiscard]] real dot(const round_change& x) const { return n * x.n + sum_of_products(t, x.t); }
};
template <>
struct round_change<false> {
  real n = 0;

  friend round_change operator+(const round_change& x, const round_change& y) {
    return {x.n + y.n};
  }
  friend round_change operator-(const round_change& x, const round_change& y) {
    return {x.n - y.n};
  }
  friend round_change operator*(real f, const round_change& x) { return {f * x.n}; }
  [[nodiscard]] real dot(const round_change& x) const { return n * x.n; }
};

/// The Delassus block of such a contact is diagonal: w_n = 1/m_a + 1/m_b along the normal and
/// w_t = w_n + arm_a^2/I_a + arm_b^2/I_b across it. So the exact local solution of Coulomb's law
/// needs no tangent basis and no tensor: r_n = max(0, r_n - (u_n - target)/w_n), and r_t - u_t/w_t
/// is clipped radially to mu r_n. Velocities are those of a relative to b, impulses act on a.
/// Without friction nothing tangential is stored or computed. Vectors are worked on as quads, which
/// is why a number follows each of them in memory.
template <class Law, partner Partner>
struct round_contact : round_friction<Law::friction> {
  static constexpr bool paired = Partner == partner::moving;
  static constexpr int rows = Law::friction ? 3 : 1;  ///< of the Delassus operator
  /// Contacts that follow each other in the list share a body, so that each would wait for the one
  /// before; contacts far apart do not, and the processor works on several at once.
  static constexpr std::size_t streams = 3;

  static constexpr real tiny = 1e-150;  ///< impulses below it are none
  using blocks = round_blocks<round_contact>;

  vec3 normal{0, 0, 1};  ///< from b to a
  real inverse_wn = 0;
  std::int32_t a = 0;
  std::int32_t b = -1;
  real target = 0;  ///< least separating velocity after the step
  real push = 0;    ///< least separating rate of the correction; at rest and under load, the rate
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
      const real limit = this->friction * rn, square = this->rt.squaredNorm();
      if (square > limit * limit) this->rt *= limit / std::sqrt(square);
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
      return {tangent(), rn};
    else
      return {rn};
  }

  /// Replaces the impulse, which may leave the cone for a while; the change is still to be applied.
  void set(const change& r) {
    rn = r.n;
    if constexpr (Law::friction) this->rt = xyz(r.t);
  }

  // What the residual is made of; see residual.hpp.
  [[nodiscard]] const vec3& axis() const { return normal; }
  [[nodiscard]] real mu() const {
    if constexpr (Law::friction)
      return this->friction;
    else
      return 0;
  }
  /// Of a against b at the point of contact; without friction its normal part alone.
  [[nodiscard]] vec3 relative_velocity(const solver_state& s) const {
    vec3 u = s.bodies[a].v;
    if constexpr (paired) u -= s.bodies[b].v;
    if constexpr (Law::friction) {
      vec3 spin = this->arm_a * s.bodies[a].w;
      if constexpr (paired) spin += this->arm_b * s.bodies[b].w;
      return u + normal.cross(spin);
    } else {
      return normal.dot(u) * normal;
    }
  }
  /// Sum of the diagonal of the Delassus block, with undivided masses.
  [[nodiscard]] real mobility_trace(const solver_state& s) const {
    const solver_body& A = s.bodies[a];
    real trace = rows * A.inverse_mass;
    if constexpr (paired) trace += rows * s.bodies[b].inverse_mass;
    if constexpr (Law::friction) {
      trace += 2 * this->arm_a * this->arm_a * A.inverse_inertia;
      if constexpr (paired) trace += 2 * this->arm_b * this->arm_b * s.bodies[b].inverse_inertia;
    }
    return trace;
  }

  // What solving several contacts as one needs; see stalled_islands.hpp.
  [[nodiscard]] mat3 axes() const { return frame_around<real>(normal); }
  [[nodiscard]] vec3 lever_a() const {
    if constexpr (Law::friction)
      return -this->arm_a * normal;
    else
      return {0, 0, 0};
  }
  [[nodiscard]] vec3 lever_b() const {
    if constexpr (Law::friction)
      return this->arm_b * normal;
    else
      return {0, 0, 0};
  }
  [[nodiscard]] change since(const change& before) const {
    if constexpr (Law::friction)
      return {tangent() - before.t, rn - before.n};
    else
      return {rn - before.n};
  }
  /// The change of velocity at the contact that a change of its impulse makes.
  [[nodiscard]] real speed_of(const change& d) const {
    real square = d.n * d.n;
    if constexpr (Law::friction) square += sum_of_products(d.t, d.t);
    return std::sqrt(square) / inverse_wn;
  }

  /// Solves this contact with all others held; the change is still to be applied.
  change relax(const solver_state& s) {
    const solver_body& A = s.bodies[a];
    const quad n = normal_quad();
    quad u = load(A.v);
    if constexpr (paired) u -= load(s.bodies[b].v);
    const real un = sum_of_products(n, u);
    const real before = rn;
    rn = std::max(real{0}, rn - (un - target) * inverse_wn);
    if constexpr (Law::friction) {
      quad spin = this->arm_a * load(A.w);
      if constexpr (paired) spin += this->arm_b * load(s.bodies[b].w);
      const quad old = load(this->rt);
      quad t = without_fourth(old - old[3] * (u - un * n + cross(n, spin)));
      // No branch: whether a contact slides is hard to predict.
      const real limit = this->friction * rn;
      t *= limit / std::max({limit, std::sqrt(sum_of_products(t, t)), tiny});
      store(this->rt, __builtin_shufflevector(t, old, 0, 1, 2, 7));
      return {t - without_fourth(old), rn - before};
    } else {
      return {rn - before};
    }
  }

  void apply(solver_state& s, const change& d) const {
    apply_to_a(s, d);
    if constexpr (paired) apply_to_b(s, d);
  }
  void apply_to_a(solver_state& s, const change& d) const {
    solver_body& A = s.bodies[a];
    real spin = 0;
    if constexpr (Law::friction) spin = this->arm_a * A.inverse_inertia;
    hit(A, d, A.inverse_mass, spin);
  }
  void apply_to_b(solver_state& s, const change& d) const {
    solver_body& B = s.bodies[b];
    real spin = 0;
    if constexpr (Law::friction) spin = this->arm_b * B.inverse_inertia;
    hit(B, d, -B.inverse_mass, spin);
  }

  real relax_push(const solver_state& s) {
    real rate = normal.dot(s.shift[a].v);
    if constexpr (paired) rate -= normal.dot(s.shift[b].v);
    const real before = pushed;
    const real next = pushed - (rate - push) * inverse_wn;
    // Surfaces that hold each other neither part nor meet but by the push.
    pushed = target == 0 && rn > 0 ? next : std::max(real{0}, next);
    return pushed - before;
  }
  void push_a(solver_state& s, real d) const {
    s.shift[a].v += (d * s.bodies[a].inverse_mass) * normal;
  }
  void push_b(solver_state& s, real d) const {
    if constexpr (paired) s.shift[b].v -= (d * s.bodies[b].inverse_mass) * normal;
  }

 private:
  [[nodiscard]] quad normal_quad() const { return without_fourth(load(normal)); }
  [[nodiscard]] quad tangent() const { return without_fourth(load(this->rt)); }

  void hit(solver_body& body, const change& d, real inverse_mass, real spin) const {
    const quad n = normal_quad();
    if constexpr (Law::friction) {
      store(body.v, load(body.v) + inverse_mass * (d.n * n + d.t));
      store(body.w, load(body.w) - spin * cross(n, d.t));
    } else {
      store(body.v, load(body.v) + (inverse_mass * d.n) * n);
    }
  }
};

}  // namespace talus::detail
