#pragma once
// Books the energy ledger and the momentum balance with soft contacts. Springs hold energy of their
// own; in finite steps the energies exchanged by bodies and springs differ slightly, and the
// difference is booked as the scheme's.
#include <cmath>

#include "talus/core/exact_batch.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/features/momentum_balance.hpp"
#include "talus/interaction/composed_law.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Energies of springs along the normal, and across it and of rolling.
struct spring_energies {
  signed_sum normal, across;
  [[nodiscard]] signed_sum sum() const {
    signed_sum all = normal;
    return all += across;
  }
};

/// The powers of the parts of a contact's force on the relative motion of its bodies. For the
/// dashpot that is the motion midway through the step as the contact alone would change it; the
/// springs bear the difference, so that the sum is the power of the force before the step.
template <class Number>
struct contact_powers {
  Number spring{}, dashpot{}, friction{};

  template <bool Central>
  [[nodiscard, gnu::always_inline]] static inline contact_powers of(
      const booked_contact_of<Number>& c, const pair_force_of<Number>& f,
      const contact_kinematics_of<Number>& t) {
    contact_powers p;
    const Number own = (real(0.5) * t.step) * dot(c.dashpot, f.force) / t.mass;
    p.spring = dot(c.spring, t.velocity) - own, p.dashpot = dot(c.dashpot, t.velocity) + own;
    if constexpr (!Central) {
      p.spring += dot(c.spring_moment, t.spin);
      p.friction = dot(c.friction, t.velocity) + dot(c.friction_moment, t.spin);
    }
    return p;
  }
};
/// The power on body a alone, or with the sign -1 on b.
[[nodiscard]] inline real power_on_body(real sign, const vec3& force, const vec3& moment,
                                        const vec3& v, const vec3& w, const vec3& arm) {
  return sign * (force.dot(vec3(v + w.cross(arm))) + moment.dot(w));
}

/// The entries of the ledger that each body adds to in a change of velocity.
struct kick_sums {
  exact_batch<signed_sum> scheme;
  explicit kick_sums(energy_record& r) : scheme(r.running.scheme) {}
};
struct no_kick_sums {};
/// Whether the forces of contacts have parts beside springs and dashpots.
template <class Scenario>
inline constexpr bool frictional_law = !world_state<Scenario>::law::law::central;
template <class Scenario>
[[nodiscard]] auto kick_sums_of(step_records<Scenario>& s) {
  if constexpr (monitored<Scenario, energy_ledger>)
    return kick_sums(s.monitors.energy);
  else
    return (void)s, no_kick_sums{};
}

/// The forces of contacts that change velocities: those that this step has computed, or those of
/// the last step. Between these two, the user may have removed, fixed or released bodies, and other
/// ranks may own them.
enum class forces_of { this_step, last_step };

/// A change of the velocities of a body, v and w, by dv and dw before damping, by forces over the
/// time h. `force` and `torque` are those of the contacts. The contacts of this step book their
/// power at the velocities before it, so that the rest of their work, of second order in h, is the
/// scheme's; so is the difference of the works of gravity here and in the free motion over the time
/// `drift` that follows.
template <forces_of Forces, class Scenario, class Store, class Sums>
void book_kick(world_state<Scenario>& s, Sums& sums, const Store& store, std::size_t i, real h,
               real drift, real kept, const vec3& force, const vec3& torque, const vec3& dv,
               const vec3& dw) {
  const vec3 &v = store.velocity[i], &w = store.angular_velocity[i];
  if constexpr (monitored<Scenario, energy_ledger>) {
    const real mass = 1 / store.inverse_mass[i];
    energy_record& r = s.monitors.energy;
    real scheme = (0.5 * h) * (force.dot(dv) + torque.dot(dw)) +
                  mass * ((h - drift * kept) * s.gravity.dot(v) +
                          (0.5 * h - drift * kept) * s.gravity.dot(dv));
    if constexpr (Forces == forces_of::last_step) scheme += h * (force.dot(v) + torque.dot(w));
    sums.scheme += scheme;
    if constexpr (Store::forced)
      r.running.work += h * (store.force[i].dot(v + 0.5 * dv) + store.torque[i].dot(w + 0.5 * dw));
    if (kept != 1) {
      const real spin = twice_spin_energy(store, i, store.pose(i).orientation, w + dw);
      r.running.damping += 0.5 * (1 - kept * kept) * (mass * (v + dv).squaredNorm() + spin);
    }
  }
  if constexpr (monitored<Scenario, momentum_balance>) {
    const real mass = 1 / store.inverse_mass[i];
    momentum_record& r = s.monitors.momentum;
    r.gravity += vec3((h * mass) * s.gravity);
    if constexpr (Store::forced) r.forces += vec3(h * store.force[i]);
    r.damping += vec3(-(1 - kept) * mass * (v + dv));
    if constexpr (Forces == forces_of::last_step) r.ground += vec3(h * force);
  }
}
/// Books the work of soft contacts, and their impulse on fixed and global bodies, over the time h.
/// The contacts of the last step may act on other bodies by now: the scheme takes what they book,
/// and the work on the present bodies. The impulse on these is that of the ground, which includes
/// bodies that were removed.
template <forces_of Forces, class Scenario>
void book_kick_of_contacts(step_records<Scenario>& s, real h) {
  if constexpr (monitored<Scenario, energy_ledger>) {
    auto& running = s.monitors.energy.running;
    spring_record& r = s.monitors.springs;
    running.work += r.wall_power.times(h);
    running.impact -= r.dashpot_power.times(h);
    running.friction -= r.friction_power.times(h);
    s.monitors.energy.exchanged.add_product(r.exchanged_power, h);
    if constexpr (Forces == forces_of::this_step) {
      running.scheme += r.spring_power.times(h);
      r.work_elsewhere += r.power_elsewhere.times(h);
    } else {
      signed_sum booked = r.wall_power;
      (booked += r.dashpot_power) += r.friction_power;
      running.scheme -= booked.times(h);
    }
  }
  if constexpr (monitored<Scenario, momentum_balance> && Forces == forces_of::this_step)
    s.monitors.momentum.ground += vec3(h * s.monitors.momentum.ground_force);
}

/// At the start of a step: `energy` is that of the springs.
template <class Scenario>
void open_springs(step_records<Scenario>& s, const signed_sum& energy) {
  spring_record& r = s.monitors.springs;
  signed_sum& entry = r.started ? s.monitors.energy.changes : s.monitors.energy.initial;
  entry += energy;
  if (r.started) entry -= r.stored;
  r.started = true;
  r.start = energy;
}

/// Before and after bodies migrate within a step: their energy goes with them. The sum over the
/// ranks changes by that of bodies that cross a periodic face.
template <class Scenario>
void book_migration(world_state<Scenario>& s, real sign) {
  const signed_sum now = energy_of(s).all();
  const auto add = [&](signed_sum& sum) { sign > 0 ? sum += now : sum -= now; };
  add(s.monitors.springs.moved), add(s.monitors.energy.changes);
}

/// The entries of a step besides those of the springs at its end.
template <class Scenario>
void close_step(step_records<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  r.step = r.running;
  r.total += r.step;
  // What springs take or give is in an entry, too: their energy at the end is not needed.
  spring_record springs = s.monitors.springs;
  springs.stored = springs.start;
  r.note_closure(closure_of(r, springs).value(), scale_of(r, springs));
}
/// `energy` is that of the springs at the end of the step, `opened` that of the tangential springs
/// of contacts that opened, and what yielded. It is lost, as is the energy of slip: the springs
/// released it, but not to motion.
template <class Scenario>
void close_springs(step_records<Scenario>& s, const signed_sum& energy, const signed_sum& lost) {
  energy_record& r = s.monitors.energy;
  spring_record& springs = s.monitors.springs;
  for (flow_sums* of : {&r.step, &r.total}) {
    of->friction += lost;
    ((of->scheme += energy) -= springs.start) += lost;
  }
  springs.stored = energy;
}

}  // namespace talus::detail
