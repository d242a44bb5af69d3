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

/// Adds the effect of a contact's springs and dashpots on a body; `sign` is that of the body.
inline void add_split(split_forces& to, real sign, const booked_contact& c, const vec3& arm,
                      bool turns) {
  const vec3 spring = sign * c.spring, dashpot = sign * c.dashpot;
  to.spring += spring, to.dashpot += dashpot;
  to.spring_torque += sign * c.spring_moment;
  if (!turns) return;
  to.spring_torque += arm.cross(spring);
  to.dashpot_torque += arm.cross(dashpot);
}

/// The power of a moving fixed body on its contact partner; `sign` is that of the other body.
inline void add_power(spring_record& r, real sign, const booked_contact& c, const vec3& u,
                      const vec3& w) {
  r.spring_power += sign * (c.spring.dot(u) + c.spring_moment.dot(w));
  r.dashpot_power += sign * c.dashpot.dot(u);
  r.friction_power += sign * (c.friction.dot(u) + c.friction_moment.dot(w));
}

/// The entries of the ledger that each body adds to in a change of velocity.
struct kick_sums {
  exact_batch<signed_sum> scheme, impact, friction;
  exact_batch<exact_sum> exchanged;
  explicit kick_sums(energy_record& r)
      : scheme(r.running.scheme),
        impact(r.running.impact),
        friction(r.running.friction),
        exchanged(r.exchanged) {}
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

/// A change of velocity by forces over the time h: to v and w, before damping. `force` and `torque`
/// are those of the contacts.
template <class Scenario, class Store, class Sums>
void book_kick(world_state<Scenario>& s, Sums& sums, const Store& store, std::size_t i, real h,
               real kept, const vec3& force, const vec3& torque, const vec3& v, const vec3& w) {
  const real mass = 1 / store.inverse_mass[i];
  if constexpr (monitored<Scenario, energy_ledger>) {
    energy_record& r = s.monitors.energy;
    const vec3 mv = 0.5 * (store.velocity[i] + v), mw = 0.5 * (store.angular_velocity[i] + w);
    const split_forces& f = store.split[i];
    const real spring = h * (f.spring.dot(mv) + f.spring_torque.dot(mw)),
               dashpot = h * (f.dashpot.dot(mv) + f.dashpot_torque.dot(mw)),
               friction = frictional_law<Scenario>
                              ? h * (vec3(force - f.spring - f.dashpot).dot(mv) +
                                     vec3(torque - f.spring_torque - f.dashpot_torque).dot(mw))
                              : 0;
    sums.scheme += spring + (h * mass) * s.gravity.dot(mv);
    sums.impact -= dashpot;
    sums.friction -= friction;
    sums.exchanged += std::abs(spring) + std::abs(dashpot) + std::abs(friction);
    if constexpr (Store::forced)
      r.running.work += h * (store.force[i].dot(mv) + store.torque[i].dot(mw));
    if (kept != 1) {
      const real spin = twice_spin_energy(store, i, store.pose(i).orientation, w);
      r.running.damping += 0.5 * (1 - kept * kept) * (mass * v.squaredNorm() + spin);
    }
  }
  if constexpr (monitored<Scenario, momentum_balance>) {
    momentum_record& r = s.monitors.momentum;
    r.gravity += vec3((h * mass) * s.gravity);
    if constexpr (Store::forced) r.forces += vec3(h * store.force[i]);
    r.damping += vec3(-(1 - kept) * mass * v);
  }
}
/// Books the work and impulse of soft contacts on fixed and global bodies over the time h.
template <class Scenario>
void book_kick_of_fixed(step_records<Scenario>& s, real h) {
  if constexpr (monitored<Scenario, energy_ledger>) {
    auto& running = s.monitors.energy.running;
    const spring_record& r = s.monitors.springs;
    const double spring = h * r.spring_power.value(), dashpot = h * r.dashpot_power.value(),
                 friction = h * r.friction_power.value();
    running.work += spring + dashpot + friction;
    running.scheme -= spring;
    running.impact += dashpot;
    running.friction += friction;
  }
  if constexpr (monitored<Scenario, momentum_balance>)
    s.monitors.momentum.ground += vec3(h * s.monitors.momentum.ground_force);
}

template <class Scenario>
[[nodiscard]] auto scheme_of_drift(step_records<Scenario>& s) {
  if constexpr (monitored<Scenario, energy_ledger>)
    return exact_batch<signed_sum>(s.monitors.energy.running.scheme);
  else
    return (void)s, no_kick_sums{};
}

/// Free motion over the time h: `w` and `q` are angular velocity and orientation before it.
template <class Scenario, class Store>
void book_drift(world_state<Scenario>& s, exact_batch<signed_sum>& scheme, const Store& store,
                std::size_t i, real h, const vec3& w, const quat& q) {
  scheme -= (h / store.inverse_mass[i]) * s.gravity.dot(store.velocity[i]);
  if constexpr (Store::tensor)
    scheme +=
        0.5 * (twice_spin_energy(store, i, store.orientation_of[i], store.angular_velocity[i]) -
               twice_spin_energy(store, i, q, w));
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

/// Before and after bodies migrate within a step: their energy goes with them.
template <class Scenario>
void book_migration(world_state<Scenario>& s, real sign) {
  const signed_sum now = energy_of(s).all();
  signed_sum& moved = s.monitors.springs.moved;
  sign > 0 ? moved += now : moved -= now;
}

/// At the end: `energy` is that of the springs; `opened` that of the tangential springs of contacts
/// that opened. It is lost, as is the energy of slip: the springs released it, but not to motion.
template <class Scenario>
void close_springs(step_records<Scenario>& s, const signed_sum& energy, const signed_sum& opened) {
  energy_record& r = s.monitors.energy;
  spring_record& springs = s.monitors.springs;
  signed_sum lost = springs.yielded;
  lost += opened;
  r.running.friction += lost;
  ((r.running.scheme += energy) -= springs.start) += lost;
  springs.stored = energy;
  r.step = r.running;
  r.total += r.step;
  r.note_closure(closure_of(r, springs).value(), scale_of(r, springs));
}

}  // namespace talus::detail
