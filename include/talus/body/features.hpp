#pragma once
// features<...>: what bodies can carry and what a run can watch beyond the necessary. What is not
// named costs nothing.
#include <type_traits>

#include "talus/body/columns.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

/// Spheres carry an orientation too. (Boxes always do.)
struct orientation final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "orientation";
  using columns = type_list<detail::columns::orientation>;
};
/// Bodies carry accumulators of force and torque.
struct forces final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "forces";
  using columns = type_list<detail::columns::force, detail::columns::torque>;
};
/// Bodies carry a number of the user's own, not unique, beside the system id.
struct user_ids final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "user_ids";
  using columns = type_list<detail::columns::user_id>;
};
/// Bodies can be made invisible to pictures.
struct visibility final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "visibility";
};
/// Velocities are damped: a fraction of them is kept per unit of time.
struct damping final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "damping";
};
/// Bodies that move far in a step stop at what they meet on their way: see world/continuous.hpp.
struct continuous_collision final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "continuous_collision";
};
/// Islands of bodies that have been at rest for a while are left out of the steps until something
/// touches them: world::sleeping, docs/architecture.md.
struct sleeping final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "sleeping";
  using columns = type_list<detail::columns::quiet>;
};
/// The cuts between domains move during the run, so that all ranks have the same to do:
/// world::balance, docs/balance.md.
struct balancing final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "balancing";
};
/// Runs write their state to a file and go on from one: <talus/checkpoint.hpp>,
/// docs/checkpoints.md.
struct checkpoints final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "checkpoints";
};
/// Runs write bodies and contacts for ParaView and Python: <talus/vtk.hpp>, docs/output.md.
struct vtk_output final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "vtk_output";
};

/// Global bodies can be moved, as functions of time or so that contacts press on them with a given
/// force: world::drive, world::hold_force, docs/building_blocks.md.
struct driven final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "driven";
};

// Monitors: they watch every step, and change no trajectory by a bit.

/// Books where energy comes from and goes to, entry by entry: observe/energy.hpp.
struct energy_ledger final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "energy_ledger";
};
/// Holds the change of momentum against what changed it, and what the ground bears against the
/// weight above it: observe/momentum.hpp.
struct momentum_balance final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "momentum_balance";
};
/// Overlaps of all steps, as detection finds them: observe/overlaps.hpp.
struct penetration_monitor final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "penetration_monitor";
};

/// The contact residual of every step: observe/residual.hpp. Over ranks it is collective.
struct residual_monitor final {
  using talus_part_of = roles::features;
  static constexpr const char* name = "residual_monitor";
};

namespace detail {

/// Bodies keep the force and torque of their contacts from step to step. Not for users: the
/// integrator asks for it.
struct contact_forces final {
  using talus_part_of = roles::features;
  using columns = type_list<columns::contact_force, columns::contact_torque>;
};
/// And they keep them in parts: the energy ledger of soft contacts asks for it.
struct split_contact_forces final {
  using talus_part_of = roles::features;
  using columns = type_list<columns::split>;
};

template <class Feature>
struct is_feature : std::bool_constant<is_part<Feature, roles::features>> {};

template <class Feature>
struct part_of_features {
  static_assert(
      is_feature<Feature>::value,
      "features<...> takes orientation, forces, user_ids, visibility, damping, "
      "continuous_collision, sleeping, balancing, checkpoints, vtk_output, driven and the monitors "
      "energy_ledger, momentum_balance, penetration_monitor and residual_monitor, and this type is "
      "none of them: remove it");
};

}  // namespace detail

/// Policy: the features in use. Default: features<>.
template <class... Features>
struct features final {
  static_assert((... && detail::examined<detail::part_of_features<Features>>));
  static_assert(detail::all_different<type_list<Features...>>,
                "features<...> names a feature twice: keep one of the two");

  using talus_role = roles::features;
  using list =
      detail::filter_types<detail::unique_types<type_list<Features...>>, detail::is_feature>;

  static std::string describe() { return detail::describe_list<Features...>("features"); }
};

}  // namespace talus
