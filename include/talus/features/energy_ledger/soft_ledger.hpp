#pragma once
// Books the energy ledger and the momentum balance with soft contacts. Springs hold energy of their
// own; in finite steps the energies exchanged by bodies and springs differ slightly, and the
// difference is booked as the scheme's.
#include <cmath>

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

/// Adds the effect of a contact's springs, dashpots and friction on a body; `sign` is that of the
/// body.
inline void add_split(split_forces& to, real sign, const booked_contact& c, const vec3& arm,
                      bool turns) {
  const vec3 spring = sign * c.spring, dashpot = sign * c.dashpot, friction = sign * c.friction;
  to.spring += spring, to.dashpot += dashpot, to.friction += friction;
  to.spring_torque += sign * c.spring_moment;
  to.friction_torque += sign * c.friction_moment;
  if (!turns) return;
  to.spring_torque += arm.cross(spring);
  to.dashpot_torque += arm.cross(dashpot);
  to.friction_torque += arm.cross(friction);
}

/// The power of a moving fixed body on its contact partner; `sign` is that of the other body.
inline void add_power(spring_record& r, real sign, const booked_contact& c, const vec3& u,
                      const vec3& w) {
  r.spring_power += sign * (c.spring.dot(u) + c.spring_moment.dot(w));
  r.dashpot_power += sign * c.dashpot.dot(u);
  r.friction_power += sign * (c.friction.dot(u) + c.friction_moment.dot(w));
}

/// A change of velocity by forces over the time h: to v and w, before damping.
template <class Scenario, class Store>
void book_kick(world_state<Scenario>& s, const Store& store, std::size_t i, real h, real kept,
               const vec3& v, const vec3& w) {
  const real mass = 1 / store.inverse_mass[i];
  if constexpr (monitored<Scenario, energy_ledger>) {
    energy_record& r = s.monitors.energy;
    const vec3 mv = 0.5 * (store.velocity[i] + v), mw = 0.5 * (store.angular_velocity[i] + w);
    const split_forces& f = store.split[i];
    const real spring = h * (f.spring.dot(mv) + f.spring_torque.dot(mw)),
               dashpot = h * (f.dashpot.dot(mv) + f.dashpot_torque.dot(mw)),
               friction = h * (f.friction.dot(mv) + f.friction_torque.dot(mw));
    r.running.scheme += spring + (h * mass) * s.gravity.dot(mv);
    r.running.impact -= dashpot;
    r.running.friction -= friction;
    r.exchanged += std::abs(spring) + std::abs(dashpot) + std::abs(friction);
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

/// Free motion over the time h: `w` and `q` are angular velocity and orientation before it.
template <class Scenario, class Store>
void book_drift(world_state<Scenario>& s, const Store& store, std::size_t i, real h, const vec3& w,
                const quat& q) {
  auto& scheme = s.monitors.energy.running.scheme;
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
