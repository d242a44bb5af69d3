#pragma once
// After a step the bodies of joints lie where their joints hold: to round-off, at any number of
// steps. Ranks that share an island of joints compute the same, each for all its bodies.
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/core/plain_vector.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"
#include "talus/step/conserve_joints.hpp"
#include "talus/step/moved_joints.hpp"

namespace talus::detail {

/// Moves the bodies to where the joints hold, by the least displacements with respect to their
/// masses (Gauss-Newton). Velocities stay. Returns whether that makes the joints better; it never
/// makes the largest error of an island larger. Notes those that stay open.
template <class Scenario>
[[nodiscard]] bool project_joints(world_state<Scenario>& s, moved_joints<Scenario>& joints) {
  return joints.close(
      [&](const moved_joint& j) {
        joints.write(j, joints.geometry(j, joints.ends));
        for (joint_line& x : joints.lines(j)) {
          if (drives(x.use)) x.use = line_use::off;
          x.target = -x.error;
        }
      },
      [&](const moved_joint& j, joint_opening open) {
        open.step = s.steps + 1, open.kind = j.kind, open.key = j.key;
        s.joints.opening.note(open);
      });
}

/// The state of jointed bodies at the start of a step.
template <class Scenario>
void note_jointed(world_state<Scenario>& s) {
  s.joints.before = find_joint_ends(s);
  locate_global_ends(s, s.joints.before, 0);
}

/// Writes what joints have changed to the bodies owned here.
template <class Scenario>
void put_moved(world_state<Scenario>& s, const plain_vector<moved_body>& bodies) {
  each_jointed(s, true, [&](auto& b, std::size_t i, std::size_t k) {
    auto& store = b.movable;
    const moved_body& to = bodies[k];
    if (to.by_joints == moved_body::change::none) return;
    const bool whole = to.by_joints == moved_body::change::step;
    // The ledger itself compares the rotational energies of bodies with a tensor.
    [[maybe_unused]] const auto energy = [&] {
      real sum = (real(0.5) * store.velocity[i].squaredNorm() - s.gravity.dot(store.position[i])) /
                 store.inverse_mass[i];
      if constexpr (!std::remove_cvref_t<decltype(store)>::tensor)
        sum += real(0.5) *
               twice_spin_energy(store, i, store.orientation_of[i], store.angular_velocity[i]);
      return sum;
    };
    if constexpr (monitored<Scenario, energy_ledger>) {
      auto& flows = s.monitors.energy.running;
      if (whole)
        flows.scheme -= energy();
      else
        flows.correction -=
            s.gravity.dot(to.end.position - store.position[i]) / store.inverse_mass[i];
    }
    store.position[i] = to.end.position, store.orientation_of[i] = to.end.orientation;
    if (whole) store.velocity[i] = to.end.velocity, store.angular_velocity[i] = to.end.spin;
    if constexpr (monitored<Scenario, energy_ledger>)
      if (whole) s.monitors.energy.running.scheme += energy();
  });
}

/// The end of the integration of a step, in scenarios with joints. Each island is moved by itself,
/// so that nothing depends on what else a rank holds.
template <class Scenario>
void settle_joints(world_state<Scenario>& s) {
  if constexpr (solves_joints_directly<Scenario>) {
    constexpr bool midpoint = world_state<Scenario>::midpoint;
    if (s.joints.size() == 0) return;
    all_moved<Scenario> moved(s, midpoint ? s.dt / 2 : s.dt);
    plain_vector<std::int32_t> numbers(moved.bodies.size(), -1);
    const auto keep = [&](const moved_joints<Scenario>& island, moved_body::change how) {
      for (std::size_t k = 0; k < island.members.size(); ++k) {
        moved_body& to = moved.bodies[island.members[k]];
        if (!to.end.moves) continue;
        to.end = island.ends[k], to.by_joints = how;
      }
    };
    for (const auto& members : moved.islands) {
      if constexpr (midpoint) {
        plain_vector<body_step> steps;
        moved_joints<Scenario> island(s, moved, members, numbers);
        const real error = conserve_with_joints(s, island, steps);
        if (error < largest_error) {
          keep(island, moved_body::change::step);
          continue;
        }
        moved_joints<Scenario> again(s, moved, members, numbers);
        if (error < useful_error) again.ends = island.ends;
        (void)project_joints(s, again);
        fit_velocities(s, again, steps);
        keep(again, moved_body::change::step);
      } else {
        moved_joints<Scenario> island(s, moved, members, numbers);
        if (project_joints(s, island)) keep(island, moved_body::change::position);
      }
    }
    put_moved(s, moved.bodies);
    if constexpr (midpoint) store_joint_impulses(s);
  }
}

}  // namespace talus::detail
