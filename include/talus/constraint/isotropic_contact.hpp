#pragma once
// A contact of bodies whose inertia is a multiple of 1 and whose contact normals pass through their
// centres: spheres, against each other or against something immovable.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/contact_bias.hpp"
#include "talus/constraint/contact_impact.hpp"
#include "talus/constraint/frame_around.hpp"
#include "talus/constraint/isotropic_blocks.hpp"
#include "talus/constraint/isotropic_rows.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/law.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack_rows.hpp"

namespace talus::detail {

/// Whether the second body of a contact can move at all; global bodies cannot.
enum class partner { moving, immovable };

/// One contact with its bodies; see isotropic_rows. Results for other code are of type real.
template <class Law, partner Partner, class Real = real>
struct isotropic_contact
    : isotropic_rows<Real, typename Law::cone, Partner == partner::moving>,
      contact_bias<has_bias<Law>>,
      contact_impact<Real, isotropic_impulse<Real, typename Law::cone>, Law::restitution> {
  using cone = typename Law::cone;
  using number = Real;
  using state = solver_state_of<Real>;
  static constexpr bool paired = Partner == partner::moving;
  static constexpr int rows = cone::rows;  ///< of the Delassus operator
  /// Consecutive contacts in the list share a body, so that each would wait for the one before;
  /// contacts far apart do not, and the processor works on several at once.
  static constexpr std::size_t streams = 3;

  using blocks = isotropic_blocks<isotropic_contact>;

  std::int32_t a = 0;
  std::int32_t b = -1;
  Real correction_rate =
      0;  ///< least separating rate of the correction; at rest and under load, the rate
  Real correction_impulse = 0;  ///< normal impulse of the correction

  using change = isotropic_impulse<Real, cone>;

  /// Effective masses; `split_a` and `split_b` are the numbers of parts into which the masses of a
  /// and b are divided if several contacts are solved simultaneously (else 1).
  void prepare(const state& s, Real split_a, Real split_b) {
    const body &A = s.bodies[a], &B = s.bodies[paired ? b : a];
    this->set_effective_mass(split_a, A.inverse_mass, A.inverse_inertia, split_b, B.inverse_mass,
                             B.inverse_inertia);
  }

  /// Warm start from an impulse of the last step, projected into the present cone.
  void load_impulse(const vec3& kept) { this->load_impulse_in(in_scalar<Real>(kept)); }
  [[nodiscard]] vec3 impulse() const {
    return in_scalar<real>(this->impulse_in_frame().along(this->normal));
  }

  // Terms of the residual; see residual.hpp.
  [[nodiscard]] decltype(auto) axis() const { return in_scalar<real>(this->normal); }
  [[nodiscard]] real mu() const { return this->coefficient(); }
  /// The velocity of a relative to b at the point of contact; without friction, only its normal
  /// component.
  [[nodiscard]] vec3 relative_velocity(const state& s) const {
    vec3 u = v_of(s.bodies[a]);
    if constexpr (paired) u -= v_of(s.bodies[b]);
    return this->resisted(u, axis(), [&] {
      vec3 spin = this->distance_a() * w_of(s.bodies[a]);
      if constexpr (paired) spin += this->distance_b() * w_of(s.bodies[b]);
      return spin;
    });
  }
  /// Sum of the diagonal of the Delassus block, with undivided masses.
  [[nodiscard]] real delassus_trace(const state& s) const {
    const auto turning = [](const body& x, Real arm) { return 2 * arm * arm * x.inverse_inertia; };
    const body& A = s.bodies[a];
    real trace = rows * A.inverse_mass;
    if constexpr (paired) trace += rows * s.bodies[b].inverse_mass;
    trace += turning(A, this->distance_a());
    if constexpr (paired) trace += turning(s.bodies[b], this->distance_b());
    return trace;
  }

  // Functions for solving several contacts as one problem; see stalled_islands.hpp.
  [[nodiscard]] mat3 axes() const { return frame_around<real>(axis()); }
  [[nodiscard]] vec3 lever_a() const { return -this->distance_a() * axis(); }
  [[nodiscard]] vec3 lever_b() const { return this->distance_b() * axis(); }
  [[nodiscard]] change since(const change& before) const {
    return this->impulse_in_frame() - before;
  }
  /// The change of velocity at the contact that a change of its impulse causes.
  [[nodiscard]] real speed_of(const change& d) const {
    return std::sqrt(d.dot(d)) / this->inverse_wn;
  }

  /// Solves this contact with all others held; the change is still to be applied.
  change relax(const state& s) {
    auto velocities = of_bodies(s, [](const body& x) { return row_of(x, x.v); });
    velocities.read();
    vector3<Real> u = velocities.relative();
    if constexpr (isotropic_contact::biased) u -= in_scalar<Real>(this->bias);
    auto spins = of_bodies(s, [](const body& x) { return row_of(x, x.w); });
    return this->solve(u, spins);
  }

  void apply(state& s, const change& d) const {
    apply_to_a(s, d);
    if constexpr (paired) apply_to_b(s, d);
  }
  void apply_to_a(state& s, const change& d) const {
    apply_to(s.bodies[a], 1, this->distance_a(), d);
  }
  void apply_to_b(state& s, const change& d) const {
    apply_to(s.bodies[b], -1, this->distance_b(), d);
  }

  Real relax_correction(const state& s) {
    Real rate = this->normal.dot(s.shift[a].v);
    if constexpr (paired) rate -= this->normal.dot(s.shift[b].v);
    return this->correct_at(rate, correction_rate, correction_impulse);
  }
  void correct_a(state& s, Real d) const {
    s.shift[a].v += (d * s.bodies[a].inverse_mass) * this->normal;
  }
  void correct_b(state& s, Real d) const {
    if constexpr (paired) s.shift[b].v -= (d * s.bodies[b].inverse_mass) * this->normal;
  }

 private:
  using body = solver_body_of<Real>;

  /// Accessors for both bodies of the contact, where `row` returns the stored values of one body.
  template <class Row>
  [[nodiscard]] auto of_bodies(const state& s, Row row) const {
    const auto at_a = [&s, row, i = a](int) { return row(s.bodies[i]); };
    const auto at_b = [&s, row, i = b](int) { return row(s.bodies[i]); };
    return ends_of_contact<Real, paired, decltype(at_a), decltype(at_b)>(at_a, at_b);
  }
  void apply_to(body& x, Real sign, Real arm, const change& d) const {
    const auto v = [&](int) { return row_of(x, x.v); };
    const auto w = [&](int) { return row_of(x, x.w); };
    ends_of_contact<Real, false, decltype(v), decltype(v)> velocity(v, v);
    velocity.read();
    velocity.push(sign * d.along(this->normal));
    velocity.write();
    ends_of_contact<Real, false, decltype(w), decltype(w)> spin(w, w);
    this->read(spin);
    this->turn(d, this->normal, arm, arm, spin);
  }
};

}  // namespace talus::detail
