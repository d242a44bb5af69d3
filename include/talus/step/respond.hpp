#pragma once
// Second and third stage of a step: velocities from forces and contacts, then positions.
#include <cmath>

#include "talus/constraint/cohesion.hpp"
#include "talus/features/continuous_collision/continuous.hpp"
#include "talus/ghosts/shared_velocities.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/solver/direct/exact_joints.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"
#include "talus/step/colour_contacts.hpp"
#include "talus/step/coloured_velocities.hpp"
#include "talus/step/finite_motion.hpp"
#include "talus/step/foreign_contacts.hpp"
#include "talus/step/kept_contacts.hpp"
#include "talus/step/passivity.hpp"
#include "talus/step/rotation_queue.hpp"

namespace talus::detail {

/// Prepares the rotation of a body in the substeps of a solver. (A body with an impact in this step
/// rotates after it, as far as its path is free.)
template <class Scenario, class Store>
void rotate_in_solver(world_state<Scenario>& s, const Store& store, std::size_t i, std::size_t k) {
  rotated_body& body = s.solver.rotated[k - s.solver.first_tensor];
  body.inertia = store.shape[i].inertia();
  if (!has_unequal_moments(body.inertia)) return;
  if constexpr (world_state<Scenario>::continuous)
    if (s.impacts.time[k] != never) return;
  body.orientation = store.orientation_of[i];
  body.time = s.dt / s.settings.iterations;
}

/// Fills the solver's arrays: velocities after forces, inverse masses and inertias.
template <class Scenario>
void gather_velocities(world_state<Scenario>& s) {
  using number = solved_scalar<Scenario>;
  auto& solver = s.solver;
  solver.fall = s.dt * s.gravity;
  solver.speed = solver.fall.norm();
  solver.tensors.resize(solver.bodies.size() - solver.first_tensor);
  if constexpr (world_state<Scenario>::law::correction) {
    solver.shift.resize(solver.bodies.size());
    solver.turn.assign(solver.tensors.size(), {});
  }
  if constexpr (!world_state<Scenario>::link_type::alone) {
    solver.boundary_contacts.assign(solver.bodies.size(), 0);
    s.passive.common.resize(solver.bodies.size());
  }
  constexpr bool divided = uses_substeps<typename Scenario::solver>;
  if constexpr (divided) {
    solver.gain.assign(solver.bodies.size(), {});
    solver.rotated.assign(solver.tensors.size(), {});
  }
  if constexpr (world_state<Scenario>::drives)
    for (std::size_t k = s.driving.first; k < solver.bodies.size(); ++k) {
      solver.tensors[k - solver.first_tensor].setZero();
      if constexpr (world_state<Scenario>::law::correction)
        solver.shift[k] = {{0, 0, 0}, solver.bodies[k].inverse_mass};
    }

  if constexpr (world_state<Scenario>::has_joints && !world_state<Scenario>::drives)
    if (const std::size_t k = s.joints.wall; k != no_wall) {
      if (k >= solver.first_tensor) solver.tensors[k - solver.first_tensor].setZero();
      solver.shift[k] = {};
    }

  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    using store_type = std::remove_reference_t<decltype(store)>;
    for (std::size_t i = 0; i < store.size(); ++i) {
      auto& body = solver.bodies[b.first + i];
      const real inverse_mass = store.asleep(i) ? 0 : store.inverse_mass[i];
      body.inverse_mass = static_cast<number>(inverse_mass);
      body.inverse_inertia = 0;
      if constexpr (world_state<Scenario>::law::correction)
        solver.shift[b.first + i] = {{0, 0, 0}, body.inverse_mass};
      if constexpr (store_type::tensor) {
        mat3& tensor = solver.tensors[b.first + i - solver.first_tensor];
        if (inverse_mass == 0) {
          tensor.setZero();
        } else {
          const vec3 inverse_moments = inverse_mass * store.shape[i].inertia().cwiseInverse();
          tensor = inverse_tensor(store.orientation_of[i], inverse_moments);
        }
      } else if (inverse_mass != 0) {
        body.inverse_inertia =
            static_cast<number>(inverse_mass * (1 / store.shape[i].inertia()[0]));
      }
      body.v = in_scalar<number>(free_velocity(s, store, i));
      body.w = in_scalar<number>(free_spin(s, store, i, b.first + i));
      if (inverse_mass == 0) continue;
      if constexpr (divided) {
        auto& gain = solver.gain[b.first + i];
        gain = {body.v - store.velocity[i], body.w - store.angular_velocity[i]};
        if constexpr (store_type::tensor) rotate_in_solver(s, store, i, b.first + i);
        if constexpr (world_state<Scenario>::continuous)  // the first part was gained before its
                                                          // impact
          if (const real t = s.impacts.time[b.first + i]; t != never) {
            const real left = (s.dt - t) / s.dt;
            gain = {left * gain.v, left * gain.w};
          }
      }
    }
  });
  if constexpr (is_cohesive<typename world_state<Scenario>::law>)
    attract<divided>(s.attraction, solver, s.dt);
}

/// Solves the contact problem with one of the solvers of the scenario.
template <class Solver, class Scenario>
void solve_contacts(world_state<Scenario>& s) {
  constexpr bool coloured = solves_by_colours<Solver>;
  if constexpr (coloured) {
    contact_colours<Scenario>(s).assign();
    if constexpr (world_state<Scenario>::law::restitution && !world_state<Scenario>::drives)
      if (s.solver.impacts) {
        auto&& lists = solver_lists<true>(s);
        each_of(lists, [&](auto& list) { list.limit_rebounds(s.solver); });
      }
  }
  if (presses(s)) s.each_contact_list([&](auto& list) { list.load_impulses(s.history); });
  constexpr bool alone = world_state<Scenario>::link_type::alone;
  if constexpr (coloured && !alone) foreign_contacts<Scenario>(s).share();
  std::conditional_t<coloured, coloured_velocities<Scenario>, shared_velocities<Scenario>> ranks(s);
  auto&& lists = solver_lists<coloured>(s);
  // The mean velocities of a step do not tell what work strikes do over ranks: it counts before.
  bool kept = false;
  if constexpr (!coloured && !alone)
    ranks.before_strikes = [&] {
      passivity(s, ranks).keep();
      kept = true;
    };
  const solved done =
      Solver::solve(lists, s.solver, s.settings, world_state<Scenario>::law::correction, ranks);
  s.convergence.add(done, s.settings.tolerance);
  if constexpr (world_state<Scenario>::has_joints && solves_joints_directly<Scenario> &&
                !requires { Solver::solves_joints; }) {
    exact_joints<std::remove_reference_t<decltype(lists)>, decltype(s.solver), decltype(ranks)>
        joints(s.solver, ranks);
    joints.solve(s.solver), joints.share_loads(lists, s.solver);
  }
  if constexpr (world_state<Scenario>::law::restitution) end_impacts(lists, s.solver);
  if constexpr (coloured && !alone) drop_foreign_bodies(s);
  // Also within a tolerance: the residual is relative to the impulses, which bounds no energy.
  if (!kept) passivity(s, ranks).keep();
}

/// Stores the impulses for the next step. Those of contacts that were kept have their places.
template <class Scenario>
void store_impulses(world_state<Scenario>& s) {
  std::size_t count = 0, kept = 0;
  s.each_contact_list([&](const auto& list) { count += list.size(); });
  constexpr bool may_keep = keeps_first_contacts<Scenario>();
  if constexpr (may_keep)
    if (s.on_one_rank())
      if (auto& first = std::get<0>(s.contacts); first.renewed() && s.history.unchanged())
        kept = first.size();
  s.history.reset(count, kept);
  if constexpr (may_keep)
    if (kept > 0) std::get<0>(s.contacts).store_in_place(s.history.entries().data());
  s.each_contact_list([&]<class List>(List& list) {
    if constexpr (keeps_contacts_in<Scenario, List>())
      if (s.on_one_rank()) {
        list.hold();
        if (kept > 0) return;
      }
    list.store_impulses(s.history);
  });
  s.history.hold();
}

/// Solves the contact problem: afterwards the solver's velocities satisfy the contact law.
template <class Scenario>
void respond(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::sleeps && !monitored<Scenario, energy_ledger>)
    if (s.settings.tolerance == 0 && !s.by_colours() && !s.solver.finishes && all_rest(s))
      return;  // no rank waits for this one
  gather_velocities(s);
  if constexpr (world_state<Scenario>::two_solvers)
    s.by_colours() ? solve_contacts<typename Scenario::solver_on_request>(s)
                   : solve_contacts<typename Scenario::solver>(s);
  else
    solve_contacts<typename Scenario::solver>(s);
  store_impulses(s);
  if constexpr (world_state<Scenario>::has_joints) store_joint_impulses(s);
}

/// Moves the bodies owned here with their new velocities.
template <class Scenario>
void integrate(world_state<Scenario>& s) {
  const auto& solver = s.solver;
  const real kept = kept_by_damping(s);
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    using store_type = std::remove_reference_t<decltype(store)>;
    constexpr bool divided = uses_substeps<typename Scenario::solver>;
    finite_watch watch;
    // Bodies that rotate for equal times do so side by side.
    constexpr bool together = store_type::tensor && !world_state<Scenario>::continuous && !divided;
    [[maybe_unused]] std::conditional_t<together, rotation_queue<store_type>, no_queue> queue;
    for (std::size_t i = 0; i < store.locals; ++i) {
      if (!store.moves(i)) continue;
      store.velocity[i] = kept * solved_velocity(s, store, i, b.first + i);
      const vec3 spin = kept * solved_spin(s, store, i, b.first + i);
      if constexpr (!together) store.angular_velocity[i] = spin;
      vec3 rate = store.velocity[i];
      real left = s.dt;
      if constexpr (world_state<Scenario>::midpoint) left *= real(0.5), rate *= real(0.5);
      [[maybe_unused]] bool struck = false;
      if constexpr (world_state<Scenario>::continuous)
        if (const real t = s.impacts.time[b.first + i]; t != never) {
          struck = true;
          if constexpr (divided)
            rate += solver.drift[b.first + i].v;
          else if constexpr (world_state<Scenario>::midpoint)
            rate = rest_velocity(s, store, i, store.velocity[i], t);
          else
            rate += (real(0.5) * t) * acceleration_of(s, store, i);
          const vec3 path = world_state<Scenario>::midpoint ? rate : store.velocity[i];
          left = s.impacts.found[b.first + i] - t;
          rate *= left / s.dt;
          if constexpr (monitored<Scenario, energy_ledger>) {
            constexpr real whole = world_state<Scenario>::midpoint ? 0.5 : 1;
            vec3 missing = s.dt * (whole * store.velocity[i] - rate);
            if constexpr (divided) missing += s.dt * solver.drift[b.first + i].v;
            book_stop(s, store, i, missing);
          }
          end_flight(s, store, i, s.dt - s.impacts.found[b.first + i], path);
        }
      if constexpr (world_state<Scenario>::law::correction)
        rate += in_scalar<real>(solver.shift[b.first + i].v);
      if constexpr (divided)
        if (!struck) rate += solver.drift[b.first + i].v;
      store.position[i] += s.dt * rate;
      if constexpr (world_state<Scenario>::continuous && world_state<Scenario>::drives)
        if (struck && s.impacts.carriers[b.first + i].from < s.dt) {
          const vec3 held = store.position[i];
          store.position[i] = carried_to(s.impacts.carriers[b.first + i], held, s.dt);
          if constexpr (monitored<Scenario, energy_ledger>)
            book_stop(s, store, i, held - store.position[i]);
        }
      watch.look(store.position[i]);  // while it is in a register
      if constexpr (together) {
        vec3 turn{0, 0, 0};
        if constexpr (world_state<Scenario>::law::correction)
          turn = s.dt * solver.turn[b.first + i - solver.first_tensor].w;
        queue.add(store, i, spin, turn, left, watch);
        continue;
      } else if constexpr (store_type::tensor) {
        if constexpr (divided)  // the last of its substeps is left
          if (const rotated_body* last = solver.rotated_at(b.first + i))
            store.orientation_of[i] = last->orientation, left = last->waiting + last->time;
        store.angular_velocity[i] = rotate_freely(
            store.orientation_of[i], store.angular_velocity[i], store.shape[i].inertia(), left);
        if constexpr (divided)  // others must not take an orientation with another energy
          if (!has_unequal_moments(store.shape[i].inertia()))
            store.orientation_of[i] =
                turned<real>(store.orientation_of[i], left * solver.drift[b.first + i].w);
        if constexpr (world_state<Scenario>::law::correction) {
          const vec3 turn = s.dt * solver.turn[b.first + i - solver.first_tensor].w;
          store.orientation_of[i] = turned<real>(store.orientation_of[i], turn);
          if constexpr (divided)  // with it, so that its energy stays
            store.angular_velocity[i] =
                turned<real>(quat(1, 0, 0, 0), turn) * store.angular_velocity[i];
        }
      } else if constexpr (store_type::oriented) {
        store.orientation_of[i] =
            turned<real>(store.orientation_of[i], left * store.angular_velocity[i]);
        if constexpr (divided)
          store.orientation_of[i] =
              turned<real>(store.orientation_of[i], left * solver.drift[b.first + i].w);
      }
      watch.look(store.angular_velocity[i]);
      if constexpr (store_type::oriented) watch.look(store.orientation_of[i]);
    }
    if constexpr (together) queue.finish(store, watch);
    if (watch.doubtful()) refuse_infinite_motion(s, store);
    if constexpr (store_type::forced) {
      std::fill(store.force.begin(), store.force.end(), vec3(0, 0, 0));
      std::fill(store.torque.begin(), store.torque.end(), vec3(0, 0, 0));
    }
  });
}

}  // namespace talus::detail
