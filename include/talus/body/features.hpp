#pragma once
// features<...>: optional data of bodies and optional functions of a run. A feature that is not
// named costs nothing. This file has the part of each feature of talus that a scenario needs: its
// name, its columns and its order. Its state, its hooks and its records are defined in
// features/ under its name; `talus_inside` marks features that work on the parts of a world
// directly.
#include <type_traits>

#include "talus/body/columns.hpp"
#include "talus/body/stages.hpp"
#include "talus/concepts.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

struct driven;
struct energy_ledger;
struct momentum_balance;
struct continuous_collision;
/// Bodies carry a film of liquid, which bridges between them take and give back:
/// <talus/liquid.hpp>.
struct surface_liquid;
/// Bodies and materials that do not touch each other: <talus/filters.hpp>.
struct contact_filters;
/// Contacts that begin and end, impacts, bodies that enter and leave regions: <talus/events.hpp>.
struct events;

/// Spheres carry an orientation too. (Boxes always do.)
struct orientation final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "orientation";
  using columns = type_list<detail::columns::orientation>;
};
/// Bodies carry accumulators of force and torque.
struct forces final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "forces";
  using columns = type_list<detail::columns::force, detail::columns::torque>;
};
/// Bodies carry a user-defined number, not unique, beside the system id.
struct user_ids final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "user_ids";
  using columns = type_list<detail::columns::user_id>;
};
/// Bodies can be made invisible to pictures.
struct visibility final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "visibility";
  using columns = type_list<>;
};
/// Velocities are damped: a fraction of them is kept per unit of time.
struct damping final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "damping";
  using columns = type_list<>;
};
/// Bodies that move far in a step stop at their first impact: see
/// features/continuous_collision/continuous.hpp.
struct continuous_collision final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "continuous_collision";
  using columns = type_list<>;
  using runs_after = type_list<driven, energy_ledger, momentum_balance>;
  template <class Scenario>
  struct state;
  struct hooks;
};
/// Islands of bodies that have been at rest for a while are left out of the steps until something
/// touches them: world::sleeping, docs/architecture.md.
struct sleeping final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "sleeping";
  using columns =
      type_list<detail::columns::quiet, detail::columns::unborne, detail::columns::drift>;
  using runs_after = type_list<driven, energy_ledger, momentum_balance, continuous_collision>;
  template <class Scenario>
  struct state;
  struct hooks;
};
/// The cuts between domains move during the run, so that all ranks have equal loads:
/// world::balance, docs/balance.md.
struct balancing final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "balancing";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
  template <class Scenario>
  struct state;
};
/// Runs write their state to a file and continue from one: <talus/checkpoint.hpp>,
/// docs/checkpoints.md.
struct checkpoints final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "checkpoints";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
};
/// Runs write bodies and contacts for ParaView and Python: <talus/vtk.hpp>, docs/output.md.
struct vtk_output final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "vtk_output";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
};

/// Global bodies can be moved, as functions of time or so that contacts press on them with a given
/// force: world::drive, world::hold_force, docs/building_blocks.md.
struct driven final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "driven";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
  template <class Scenario>
  struct state;
  struct hooks;
};

// Monitors: they observe every step, and change no bit of a trajectory.

/// Books the sources and sinks of energy, entry by entry: observe/energy.hpp.
struct energy_ledger final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "energy_ledger";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
  using runs_after = type_list<driven>;
  struct record;
  struct hooks;
};
/// Compares the change of momentum with its sources, and the load on the ground with the weight
/// above it: observe/momentum.hpp.
struct momentum_balance final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "momentum_balance";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
  using runs_after = type_list<driven, energy_ledger>;
  struct record;
  struct hooks;
};
/// Overlaps of all steps, as found by detection: observe/overlaps.hpp.
struct penetration_monitor final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "penetration_monitor";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
  struct record;
  struct hooks;
};

/// The contact residual of every step: observe/residual.hpp. Over ranks it is collective.
struct residual_monitor final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  static constexpr const char* name = "residual_monitor";
  static constexpr bool checkpoints_may_differ = true;
  using columns = type_list<>;
  struct hooks;
};

namespace detail {

/// Bodies keep the force and torque of their contacts from step to step. Not for users: an
/// integrator requires it.
struct contact_forces final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  using columns = type_list<columns::contact_force, columns::contact_torque>;
};
/// What springs and dashpots of soft contacts do: the energy ledger requires it.
struct contact_flows final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  using columns = type_list<>;
  struct record;
};
/// What motors, springs and friction of joints do: the energy ledger requires it in scenarios with
/// joints.
struct joint_flows final {
  using talus_inside = void;
  using talus_part_of = roles::features;
  using columns = type_list<>;
  struct record;
};

template <class Feature>
struct is_feature : std::bool_constant<concepts::feature<Feature>> {};

/// A feature of talus, as opposed to a user-defined one.
template <class Feature>
concept built_in = requires {
  typename Feature::talus_inside;
};
template <class Feature>
concept with_hooks = requires {
  typename Feature::hooks;
};

/// Whether a run without the feature may continue from a checkpoint of a run with it.
template <class Feature>
inline constexpr bool checkpoints_may_differ = false;
template <class Feature>
requires requires { Feature::checkpoints_may_differ; }
inline constexpr bool checkpoints_may_differ<Feature> = Feature::checkpoints_may_differ;

/// Stands for the argument of a hook.
struct any_stage {};
/// Whether a feature has a hook that keeps pairs of bodies apart; see pairs/filtered_pairs.hpp.
template <class Feature>
inline constexpr bool filters_pairs = false;
template <with_hooks Feature>
requires(!built_in<Feature>) inline constexpr bool filters_pairs<Feature> =
    requires(const any_stage& pair) {
  Feature::hooks::may_touch(pair);
};
template <class Features>
inline constexpr bool some_filter_pairs = false;
template <class... Features>
inline constexpr bool some_filter_pairs<type_list<Features...>> = (filters_pairs<Features> || ...);
template <class Hooks, class... Stages>
[[nodiscard]] consteval bool names_a_stage(type_list<Stages...>) {
  return (requires(any_stage & s) { Stages::template call<Hooks>(s); } || ...);
}
template <class Feature>
[[nodiscard]] consteval bool hooks_are_known() {
  if constexpr (with_hooks<Feature> && !built_in<Feature>)
    return names_a_stage<typename Feature::hooks>(stages::all{}) || filters_pairs<Feature>;
  else
    return true;
}
template <class Columns>
inline constexpr bool are_columns = false;
template <class... Columns>
inline constexpr bool are_columns<type_list<Columns...>> = (concepts::column<Columns> && ...);

template <class Feature>
struct part_of_features {
  static_assert(!is_part<Feature, roles::features> || is_feature<Feature>::value,
                "features<...> takes a feature with a name and with columns, a state or hooks, and "
                "this type has not all of that: docs/features.md says how a feature is written");
  static_assert(!is_feature<Feature>::value || hooks_are_known<Feature>(),
                "the hooks of a feature are static functions named after the stages of a step, or "
                "may_touch, and this feature has none of these names: docs/features.md lists them");
  static_assert(!is_feature<Feature>::value ||
                    are_columns<typename columns_of_feature<Feature>::type>,
                "the columns of a feature are a type_list of descriptions with a value_type and a "
                "name, and this feature has others: docs/features.md says how a column is written");
  static_assert(
      is_part<Feature, roles::features>,
      "features<...> takes orientation, forces, user_ids, visibility, damping, "
      "continuous_collision, sleeping, balancing, checkpoints, vtk_output, driven, events, "
      "contact_filters and the monitors energy_ledger, momentum_balance, penetration_monitor and "
      "residual_monitor, and features of "
      "one's own (docs/features.md), and this type is not one of them: remove it");
};

}  // namespace detail

/// Policy: the features in use. Default: features<>.
template <class... Features>
struct features final {
  static_assert((... && (sizeof(detail::examined<detail::part_of_features, Features>) > 0)));
  static_assert(detail::all_different<type_list<Features...>>,
                "features<...> names a feature twice: keep one of the two");

  using talus_role = roles::features;
  using list =
      detail::filter_types<detail::unique_types<type_list<Features...>>, detail::is_feature>;

  static std::string describe() { return detail::describe_list<Features...>("features"); }
};

}  // namespace talus
