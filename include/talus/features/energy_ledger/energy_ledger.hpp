#pragma once
// features<energy_ledger>: its record, how it books a step (every entry is computed on its own,
// none as the remainder), and its stages.
#include <algorithm>
#include <cmath>

#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/joint_line.hpp"
#include "talus/core/exact_batch.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/state/monitors.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"

namespace talus {

/// Energy that entered or left the motion of the bodies. Each entry is computed on its own.
struct energy_flows {
  double work = 0;        ///< done by forces and torques of the user, and by fixed bodies with a
                          ///< velocity on the bodies that they carry along; that of a servo on
                          ///< hard contacts is its force times its way
  double motors = 0;      ///< done by motors of joints
  double springs = 0;     ///< done by springs and dampers of joints; below 0 while springs are bent
  double friction = 0;    ///< dissipated by tangential impulses
  double impact = 0;      ///< dissipated by normal impulses, and by those of joints
  double damping = 0;     ///< dissipated by damping
  double correction = 0;  ///< added by the position correction, of either sign with servos
  double scheme = 0;      ///< added by the time stepping: -m g^2 dt^2/2 per step of a free fall,
                          ///< and the error of the rotation scheme
  double sleep = 0;       ///< dissipated when islands were put to sleep
  double joint_friction = 0;  ///< dissipated by friction of joints

  [[nodiscard]] double net() const {
    return work + motors + springs + correction + scheme - friction - impact - damping - sleep -
           joint_friction;
  }
};

namespace detail {

/// Kinetic and potential energy, and the sum of their absolute values over the bodies.
struct energy_sums {
  exact_sum kinetic, scale;
  signed_sum potential;

  [[nodiscard]] signed_sum all() const {
    signed_sum sum = potential;
    sum.plus += kinetic;
    return sum;
  }
};

/// Sums of energy_flows over bodies, contacts and steps.
struct flow_sums {
  signed_sum work, friction, impact, damping, correction, scheme, sleep;

  [[nodiscard]] energy_flows value() const {
    return {.work = work.value(),
            .friction = friction.value(),
            .impact = impact.value(),
            .damping = damping.value(),
            .correction = correction.value(),
            .scheme = scheme.value(),
            .sleep = sleep.value()};
  }
  [[nodiscard]] signed_sum net() const {
    signed_sum sum;
    for (const signed_sum* gain : {&work, &correction, &scheme}) sum += *gain;
    for (const signed_sum* loss : {&friction, &impact, &damping, &sleep}) sum -= *loss;
    return sum;
  }
  template <class F>
  void each(F&& f) {
    f(work, friction, impact, damping, correction, scheme, sleep);
  }
  flow_sums& operator+=(const flow_sums& x) {
    work += x.work, friction += x.friction, impact += x.impact, damping += x.damping;
    correction += x.correction, scheme += x.scheme, sleep += x.sleep;
    // Large gains and losses alternate; many steps must not exhaust the digits.
    each([](auto&... sums) { (exact_sum::cancel(sums.plus, sums.minus), ...); });
    return *this;
  }
};

struct energy_entries {
  flow_sums running;          ///< of the step under way
  exact_sum exchanged;        ///< absolute works of contacts and rows of joints in the last step
  energy_sums before, after;  ///< of the last step
  flow_sums step, total;
  signed_sum initial;  ///< energy at the start of the first step
  signed_sum changes;  ///< of energy by the user, between the steps
  double largest = 0;  ///< scale of all steps, on this rank
  double worst = 0;    ///< largest |closure| over scale of all steps, on this rank
  bool started = false;

  /// Records the closure of a step relative to the scale of its energies. Once all bodies are at
  /// rest only round-off is left, so the scale is at least a small part of the largest one so far.
  void note_closure(double closure, double scale) {
    largest = std::max(largest, scale);
    const double least = 1e-12 * largest;
    if (scale > 0) worst = std::max(worst, std::abs(closure) / std::max(scale, least));
  }

  template <class Visitor>
  void each_number(Visitor& visit) {
    for (energy_sums* s : {&before, &after}) visit.sums(s->kinetic, s->potential, s->scale);
    for (flow_sums* e : {&step, &total}) e->each([&](auto&... sums) { visit.sums(sums...); });
    visit.sums(initial, changes, exchanged);
    visit.largest(largest);
    visit.largest(worst);
    visit.largest(started);
  }
};
struct energy_record : energy_entries {
  /// The mean of the velocities of a body before and after a step. With it the work of impulses
  /// that act together is the sum of their works.
  struct mean_velocity {
    vec3 v, w;
  };
  plain_vector<mean_velocity> mean;  ///< of all bodies known here, in the solver's order
};

/// Works of motors and springs of joints, and what their friction dissipates.
struct drive_sums {
  signed_sum motors, springs, friction;

  void add_to(energy_flows& x) const {
    x.motors = motors.value(), x.springs = springs.value(), x.joint_friction = friction.value();
  }
  [[nodiscard]] signed_sum net() const {
    signed_sum sum = motors;
    (sum += springs) -= friction;
    return sum;
  }
  template <class F>
  void each(F&& f) {
    f(motors, springs, friction);
  }
  drive_sums& operator+=(const drive_sums& x) {
    motors += x.motors, springs += x.springs, friction += x.friction;
    each([](auto&... sums) { (exact_sum::cancel(sums.plus, sums.minus), ...); });
    return *this;
  }
};
/// Further entries for joints.
struct drive_record {
  drive_sums running, step, total;

  template <class Visitor>
  void each_number(Visitor& visit) {
    for (drive_sums* x : {&step, &total}) x->each([&](auto&... sums) { visit.sums(sums...); });
  }
};

/// Further entries for soft contacts: the energy of the springs of those contacts that count on
/// this rank.
struct spring_record {
  /// Power of the present forces on the relative motion of the bodies, when they were computed.
  signed_sum spring_power, dashpot_power, friction_power;
  exact_sum exchanged_power;  ///< absolute values of these
  signed_sum wall_power;      ///< of moving fixed bodies on others
  /// The part of the power of the contacts that count here on bodies of other ranks, minus that of
  /// contacts that count there on bodies owned here; and its work since it was computed.
  signed_sum power_elsewhere, work_elsewhere;
  /// Energies at the last computation of forces: along the normal, and across it (and of rolling)
  /// before and after the springs were advanced; energy lost by slip between.
  signed_sum normal, across_before, across, yielded;
  signed_sum released;  ///< of `normal`, released when the memory changed
  signed_sum start;     ///< energy at the start of the step
  signed_sum across_at_start;
  signed_sum stored;  ///< and at its end
  signed_sum moved;   ///< energy of the bodies that migrated to this rank within the step
  bool started = false;
  /// Nothing but steps has happened since the end of the last step, so that the next one finds its
  /// energies; if forces are computed at the start of a step, that of the springs is known then.
  bool undisturbed = false;
  signed_sum unclosed;  ///< yielded + across of that step

  void measure_anew() {
    spring_power = dashpot_power = friction_power = wall_power = power_elsewhere = {};
    exchanged_power = {};
    normal = across_before = across = yielded = released = {};
  }
  template <class Visitor>
  void each_number(Visitor& visit) {
    visit.sums(spring_power, dashpot_power, friction_power, exchanged_power, wall_power);
    visit.sums(power_elsewhere, work_elsewhere);
    visit.sums(normal, across_before, across, yielded, released);
    visit.sums(start, across_at_start, stored, moved);
    visit.largest(started);
  }
};

/// Calls f(store, i, index in the solver's arrays) for each body owned here that can move.
template <class Scenario, class F>
void each_moving_local(const held_bodies<Scenario>& s, F&& f) {
  s.each_finite_shape([&](auto& b) {
    for (std::size_t i = 0; i < b.movable.locals; ++i)
      if (b.movable.inverse_mass[i] != 0) f(b.movable, i, b.first + i);
  });
}

/// Twice the rotational energy of body i, rotated by q, at angular velocity w.
template <class Store>
[[nodiscard]] real twice_spin_energy(const Store& store, std::size_t i, const quat& q,
                                     const vec3& w) {
  const real mass = 1 / store.inverse_mass[i];
  if constexpr (Store::tensor) {
    const vec3 own = q.conjugate() * w;
    return mass * store.shape[i].inertia().dot(own.cwiseProduct(own));
  } else {
    return (mass * store.shape[i].inertia()[0]) * w.squaredNorm();
  }
}

/// The present energies of the bodies owned by this rank.
template <class Scenario>
[[nodiscard]] energy_sums energy_of(const world_state<Scenario>& s) {
  energy_sums sums;
  exact_sum high, low;  // potential energies above 0, and minus those below
  exact_batch kinetic(sums.kinetic), of_high(high), of_low(low);
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t) {
    const real mass = 1 / store.inverse_mass[i], fall = mass * s.gravity.dot(store.position[i]);
    kinetic +=
        0.5 * (mass * store.velocity[i].squaredNorm() +
               twice_spin_energy(store, i, store.pose(i).orientation, store.angular_velocity[i]));
    if (fall > 0)
      of_low += fall;
    else
      of_high -= fall;
  });
  kinetic.flush(), of_high.flush(), of_low.flush();
  sums.potential.plus = high, sums.potential.minus = low;
  ((sums.scale += sums.kinetic) += high) += low;
  return sums;
}

/// Whether the energies of the bodies owned here are those at the end of the last step. If bodies
/// migrate after that, their owners change, and the potential energy of a body that crosses a
/// periodic face.
template <class Scenario>
[[nodiscard]] bool keeps_energies(const world_state<Scenario>& s) {
  if constexpr (Scenario::contact_law::soft)
    return s.monitors.springs.undisturbed &&
           (Scenario::integrator::shares_midway ||
            (s.link->size() == 1 && !world_state<Scenario>::periodic));
  else
    return (void)s, false;
}
/// Before a step: the user's changes since the last one.
template <class Scenario>
void open_energy(world_state<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  r.running = {};
  r.exchanged = {};
  if constexpr (world_state<Scenario>::has_joints) s.monitors.drives.running = {};
  if (keeps_energies(s)) {
    r.before = r.after;
    return;
  }
  r.before = energy_of(s);
  if (r.started)
    (r.changes += r.before.all()) -= r.after.all();
  else
    r.initial = r.before.all();
  r.started = true;
}

/// Works of the contacts. Impulses change the velocities together, and the change of m v^2/2 is
/// that of m v times the mean of v before and after. So each impulse, including the warm start,
/// does work on the mean velocity of its point, and these works add up to the change of kinetic
/// energy exactly. The works on both bodies are booked separately: a rank books those on the bodies
/// it moves, and the sums over the ranks depend on no distribution.
template <class Scenario>
void book_contacts(world_state<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  const auto& solver = s.solver;
  s.each_contact_list([&]<class List>(const List& list) {
    list.each_acting([&](const auto& c, bool on_a, bool on_b) {
      using contact = std::remove_cvref_t<decltype(c)>;
      const split_impulse p = impulse_in_parts(c);
      const auto lose = [&](const vec3& u, real sign) {
        const real normal = p.normal.dot(u), tangential = p.tangential.dot(u);
        r.running.impact -= sign * normal;
        r.running.friction -= sign * tangential;
        r.exchanged += std::abs(normal) + std::abs(tangential);
      };
      const auto a = static_cast<std::size_t>(c.a);
      if (on_a) {
        const auto& m = r.mean[a];
        const vec3 u = velocity_on_a(c, m.v, m.w);
        lose(u, 1);
        if (solver.bodies[a].inverse_mass == 0) r.running.work -= (p.normal + p.tangential).dot(u);
      }
      if constexpr (contact::paired)
        if (on_b) {
          const auto b = static_cast<std::size_t>(c.b);
          const auto& m = r.mean[b];
          const vec3 u = velocity_on_b(c, m.v, m.w);
          lose(u, -1);
          if (solver.bodies[b].inverse_mass == 0 || b >= solver.first_global)
            r.running.work += (p.normal + p.tangential).dot(u);
        }
    });
  });
  // The solver's impulses do not contain the attraction of normal_cohesion.
  if constexpr (is_cohesive<typename world_state<Scenario>::law>)
    s.attraction.each(s.dt, [&](std::size_t k, const vec3& p, const vec3& moment) {
      bool owned = false;
      s.each_finite_shape(
          [&](const auto& b) { owned |= k >= b.first && k - b.first < b.movable.locals; });
      if (!owned) return;
      const real work = p.dot(r.mean[k].v) + moment.dot(r.mean[k].w);
      if (solver.bodies[k].inverse_mass == 0) r.running.work -= work;
      r.running.impact -= work;
      r.exchanged += std::abs(work);
    });
}

/// Books the work of the impulses of joints. The impulses of the conditions do no work at the exact
/// velocities; the work that they do is booked as impact: it belongs to the part of the velocities
/// that the rotation of a step has brought across the joint. Motors, springs and friction do work.
template <class Scenario>
void book_joints(world_state<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  drive_sums& drives_of = s.monitors.drives.running;
  const auto& solver = s.solver;
  s.each_joint_list([&](const auto& list) {
    list.each_acting([&](const auto& c, bool on_a, bool on_b) {
      const auto book = [&](bool of_a) {
        const auto k = static_cast<std::size_t>(of_a ? c.a : c.b);
        const bool given = solver.bodies[k].inverse_mass == 0 || k >= solver.first_global;
        c.each_work(of_a, r.mean[k].v, r.mean[k].w, [&](const joint_line& x, real work) {
          if (given) r.running.work -= work;
          // A motor and a spring may work against each other, with works far above their sum.
          r.exchanged += std::abs(work);
          switch (x.use) {
            case line_use::motor:
              drives_of.motors += work;
              break;
            case line_use::spring:
              drives_of.springs += work;
              break;
            case line_use::friction:
              drives_of.friction -= work;
              break;
            default:
              r.running.impact -= work;
          }
        });
      };
      if (on_a) book(true);
      if (on_b) book(false);
    });
  });
}

/// After the response, before positions move: velocities before it are still in the store, those
/// after it in the solver's arrays.
template <class Scenario>
void book_response(world_state<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  const auto& solver = s.solver;
  const real kept = kept_by_damping(s), lost = 1 - kept * kept;
  r.mean.resize(solver.bodies.size());
  s.each_finite_shape([&](const auto& b) {
    for (std::size_t i = 0; i < b.movable.size(); ++i) {
      const std::size_t k = b.first + i;
      r.mean[k] = {0.5 * (b.movable.velocity[i] + solved_velocity(s, b.movable, i, k)),
                   0.5 * (b.movable.angular_velocity[i] + solved_spin(s, b.movable, i, k))};
    }
  });
  if constexpr (world_state<Scenario>::has_joints)
    if (s.joints.wall != no_wall) r.mean[s.joints.wall] = {{0, 0, 0}, {0, 0, 0}};
  if constexpr (world_state<Scenario>::drives)
    for (std::size_t k = s.driving.first; k < solver.bodies.size(); ++k)
      r.mean[k] = {v_of(solver.bodies[k]), w_of(solver.bodies[k])};
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t k) {
    using store_type = std::remove_cvref_t<decltype(store)>;
    const real mass = 1 / store.inverse_mass[i];
    const auto& mean = r.mean[k];
    const vec3& v = solved_velocity(s, store, i, k);
    const vec3& w = solved_spin(s, store, i, k);
    const vec3 pull = (s.dt * mass) * s.gravity;
    // Gravity changes the speed at the mean velocity and the height at the last one.
    if constexpr (world_state<Scenario>::midpoint)  // and the height at both, half of the time each
      r.running.scheme += (real(0.5) * (1 - kept)) * pull.dot(vec3(v - store.velocity[i] / kept));
    else
      r.running.scheme += pull.dot(mean.v - kept * v);
    if constexpr (store_type::forced)
      r.running.work += s.dt * (store.force[i].dot(mean.v) + store.torque[i].dot(mean.w));
    if constexpr (world_state<Scenario>::law::correction)
      r.running.correction += -pull.dot(in_scalar<real>(solver.shift[k].v));
    if constexpr (uses_substeps<typename Scenario::solver>)
      r.running.scheme += -pull.dot(solver.drift[k].v);
    const bool damped = kept != 1;
    if (!damped && !store_type::tensor) return;
    real spin = twice_spin_energy(store, i, store.pose(i).orientation, w);
    if constexpr (uses_substeps<typename Scenario::solver> && store_type::tensor)
      if (const rotated_body* last = solver.rotated_at(k)) {
        // Its angular momentum has been constant between impulses, not its angular velocity.
        rotated_body first = *last;
        first.orientation = store.orientation_of[i];
        spin = mass * last->momentum(w).dot(w);
        r.running.scheme += real(-0.5) * mass *
                            (last->momentum(w).dot(store.angular_velocity[i]) -
                             first.momentum(store.angular_velocity[i]).dot(w));
      }
    if (damped) r.running.damping += (0.5 * lost) * (mass * v.squaredNorm() + spin);
    if constexpr (store_type::tensor) r.running.scheme += -0.5 * kept * kept * spin;
  });
  book_contacts(s);
  if constexpr (world_state<Scenario>::has_joints) book_joints(s);
}

/// Books the motion of a body that continuous collision has moved to its impact before the
/// response. `from` and `w` are its pose and angular velocity before that.
template <class Scenario, class Store>
void book_flight(world_state<Scenario>& s, const Store& store, std::size_t i, const pose& from,
                 const vec3& w) {
  auto& scheme = s.monitors.energy.running.scheme;
  scheme += -s.gravity.dot(store.position[i] - from.position) / store.inverse_mass[i];
  if constexpr (Store::tensor)
    scheme +=
        0.5 * (twice_spin_energy(store, i, store.orientation_of[i], store.angular_velocity[i]) -
               twice_spin_energy(store, i, from.orientation, w));
}
/// After the impact it moved by less than its last velocity times the step: by `missing`.
template <class Scenario, class Store>
void book_stop(world_state<Scenario>& s, const Store& store, std::size_t i, const vec3& missing) {
  s.monitors.energy.running.scheme += s.gravity.dot(missing) / store.inverse_mass[i];
}

/// After positions have moved. In the response each part of a servo has a velocity of its own, and
/// its contacts are booked with it. The servo goes the mean way of its parts, and of their position
/// corrections: its work is its force times that way, and the rest belongs to the correction.
template <class Scenario>
void book_servos(world_state<Scenario>& s) {
  const auto& d = s.driving;
  if (std::none_of(d.all.begin(), d.all.end(), [](const auto& one) { return one->is_servo; }))
    return;
  energy_record& r = s.monitors.energy;
  s.each_contact_list([&](const auto& list) {
    list.each_acting([&](const auto& c, bool, bool on_b) {
      if constexpr (std::remove_cvref_t<decltype(c)>::paired) {
        const auto b = static_cast<std::size_t>(c.b);
        if (!on_b || b < d.first || d.owners[b - d.first] < 0) return;
        const auto& one = *d.all[static_cast<std::size_t>(d.owners[b - d.first])];
        if (!one.is_servo) return;
        const split_impulse p = impulse_in_parts(c);
        const auto& part = r.mean[b];
        const real rest =
            (p.normal + p.tangential)
                .dot((one.next.end.point - one.from) / s.dt - velocity_on_b(c, part.v, part.w));
        r.running.work += rest;
        r.running.correction += -rest;
      }
    });
  });
}

/// After positions have moved: the change of rotational energy by free rotation and by the position
/// correction. The correction rotates bodies last and does not change their angular velocity; in
/// steps with substeps it rotates that as well, and the energy stays.
template <class Scenario>
void book_motion(world_state<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  each_moving_local(s, [&](auto& store, std::size_t i, std::size_t k) {
    if constexpr (std::remove_cvref_t<decltype(store)>::tensor) {
      const vec3& w = store.angular_velocity[i];
      const quat& last = store.orientation_of[i];
      quat free = last;
      if constexpr (world_state<Scenario>::law::correction &&
                    !uses_substeps<typename Scenario::solver>)
        free = turned<real>(last, -s.dt * s.solver.turn[k - s.solver.first_tensor].w);
      const real spin = twice_spin_energy(store, i, free, w);
      r.running.scheme += 0.5 * spin;
      if constexpr (world_state<Scenario>::law::correction)
        r.running.correction += 0.5 * (twice_spin_energy(store, i, last, w) - spin);
    }
    (void)k;
  });
}

/// The difference that the entries of the last step leave.
[[nodiscard]] inline signed_sum closure_of(const energy_entries& r) {
  signed_sum left = r.after.all();
  (left -= r.before.all()) -= r.step.net();
  return left;
}
[[nodiscard]] inline double scale_of(const energy_entries& r) {
  return std::max(r.before.scale.value(), r.after.scale.value()) + r.exchanged.value();
}
/// The difference that the entries of the last step leave, with the energy of the springs of soft
/// contacts.
[[nodiscard]] inline signed_sum closure_of(const energy_entries& r, const spring_record& springs) {
  signed_sum left = closure_of(r);
  ((left += springs.stored) -= springs.start) -= springs.moved;
  left += springs.work_elsewhere;
  return left;
}
[[nodiscard]] inline double scale_of(const energy_entries& r, const spring_record& springs) {
  return scale_of(r) + std::abs(springs.moved.value()) +
         std::max(springs.stored.value(), springs.start.value());
}

/// At the end of a step, before bodies are migrated.
template <class Scenario>
void close_energy(world_state<Scenario>& s) {
  energy_record& r = s.monitors.energy;
  r.after = energy_of(s);
  r.step = r.running;
  r.total += r.step;
  signed_sum left = closure_of(r);
  if constexpr (world_state<Scenario>::has_joints) {
    drive_record& d = s.monitors.drives;
    d.step = d.running;
    d.total += d.step;
    left -= d.step.net();
  }
  r.note_closure(left.value(), scale_of(r));
}

}  // namespace detail

struct energy_ledger::record {
  detail::energy_record energy;

  template <class F>
  void each_record(F&& f) {
    f("energy", energy);
  }
};
struct detail::joint_flows::record {
  drive_record drives;

  template <class F>
  void each_record(F&& f) {
    f("drives", drives);
  }
};
struct detail::contact_flows::record {
  spring_record springs;

  template <class F>
  void each_record(F&& f) {
    f("springs", springs);
  }
};

// With soft contacts, energies are measured once the last velocities of a step are known, and the
// spring energy is that of the positions at which forces are computed: at the start of a step, or
// at its end if the integrator shares bodies midway.
struct energy_ledger::hooks {
  template <class Scenario>
  static void at_start(detail::world_state<Scenario>& s) {
    open_energy(s);
    if constexpr (Scenario::contact_law::soft) {
      s.monitors.springs.moved = s.monitors.springs.work_elsewhere = {};
      if constexpr (Scenario::integrator::shares_midway) open_springs_midway(s);
    }
  }
  template <class Scenario>
  static void after_solve(detail::world_state<Scenario>& s) {
    if constexpr (!Scenario::contact_law::soft) book_response(s);
  }
  template <class Scenario>
  static void after_move(detail::world_state<Scenario>& s) {
    if constexpr (!Scenario::contact_law::soft) {
      if constexpr (detail::world_state<Scenario>::drives) book_servos(s);
      book_motion(s);
    }
  }
  template <class Scenario>
  static void at_close(detail::world_state<Scenario>& s) {
    if constexpr (!Scenario::contact_law::soft) {
      close_energy(s);
    } else {
      s.monitors.energy.after = energy_of(s);
      if constexpr (Scenario::integrator::shares_midway) close_springs_as_measured(s);
    }
  }
  template <class Scenario>
  static void before_share(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::integrator::shares_midway) book_migration(s, -1);
  }
  template <class Scenario>
  static void after_share(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::integrator::shares_midway) book_migration(s, 1);
  }
  template <class Scenario>
  static void at_end(detail::world_state<Scenario>& s) {
    if constexpr (Scenario::contact_law::soft && !Scenario::integrator::shares_midway)
      leave_springs_open(s);
  }
};

}  // namespace talus
