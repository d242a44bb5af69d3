#pragma once
// The course of a contact or joint over the substeps of a step.
#include <algorithm>
#include <cstddef>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/rebound.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// State of a contact in a step with substeps.
template <class Contact>
struct contact_course {
  real gap = 0;          ///< over the length of the whole step; an overlap counts as 0
  real restitution = 0;  ///< if the detection predicted an impact
  bool apart = false;    ///< at the start of the step
  typename Contact::change last, total;

  /// From the conditions of the detection, which are documented in conditions_of of
  /// step/detect.hpp. `held` is a gap that counts as closed.
  contact_course(Contact& c, const solver_state& s, real part, real held)
      : gap(c.target_velocity < 0   ? -c.target_velocity
            : c.target_velocity > 0 ? std::max(real{0}, -c.correction_rate)
                                    : 0),
        apart(c.target_velocity < 0 || gap > held),
        total(0 * c.impulse_in_frame()) {
    if (c.target_velocity > 0)
      restitution = std::clamp(-c.target_velocity / approach(c, s), real{0}, real{1});
    c.set(part * c.impulse_in_frame());
  }

  /// Sets the conditions of the contact in the coming substep, from the velocities before it.
  /// `moved` is the part of the step for which surfaces have moved with these.
  void advance(Contact& c, const solver_state& s, real part, real moved, real held) {
    last = c.impulse_in_frame();
    const real un = approach(c, s);
    gap = std::max(real{0}, gap + un * moved);
    c.target_velocity = gap > held || restitution > 0 ? -gap / part : 0;
    // Points of a face that differ by round-off meet in the same substep.
    if (restitution == 0 || un >= 0 || gap + (1 + real(1e-6)) * un * part > 0) return;
    const real fall = -c.axis().dot(gain(c, s));  // the length of the whole step is 1 here
    c.target_velocity = rebound(restitution, un, gap, part, fall);
  }
  void add(const Contact& c) { total = total + c.impulse_in_frame(); }
  /// After the last one. The position correction may close what is left of a gap.
  void finish(Contact& c, const solver_state& s, real part) {
    c.set(total);
    if (apart) c.correction_rate = -std::max(real{0}, gap + approach(c, s) * part);
  }
  /// Whether the impulse has changed in the substep as in an impact: velocities by more than
  /// `speed`.
  [[nodiscard]] bool changes(const Contact& c, const solver_state& s, real speed) const {
    const auto d = c.since(last);
    real mass = s.bodies[static_cast<std::size_t>(c.a)].inverse_mass;
    if constexpr (Contact::paired) mass += s.bodies[static_cast<std::size_t>(c.b)].inverse_mass;
    return mass * mass * d.dot(d) > speed * speed;
  }

 private:
  static vec3 gain(const Contact& c, const solver_state& s) {
    vec3 v = s.gain[static_cast<std::size_t>(c.a)].v;
    if constexpr (Contact::paired) v -= s.gain[static_cast<std::size_t>(c.b)].v;
    return v;
  }
  static real approach(const Contact& c, const solver_state& s) {
    return c.axis().dot(c.relative_velocity(s));
  }
};

/// The course of a joint in a step with substeps; its conditions do not change.
template <class Contact>
requires is_joint<Contact>
struct contact_course<Contact> {
  typename Contact::change total;

  contact_course(Contact& c, const solver_state&, real part, real)
      : total(0 * c.impulse_in_frame()) {
    c.take_part(part);
    c.set(part * c.impulse_in_frame());
  }
  void advance(Contact&, const solver_state&, real, real, real) {}
  void add(const Contact& c) { total = total + c.impulse_in_frame(); }
  void finish(Contact& c, const solver_state&, real part) {
    c.set(total);
    c.take_part(1 / part);
  }
};

}  // namespace talus::detail
