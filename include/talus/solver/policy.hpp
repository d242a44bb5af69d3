#pragma once
// solver<...> and integrator<...>: how contact impulses are computed, and how motion is advanced.
#include <type_traits>

#include "talus/concepts.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/policy.hpp"
#include "talus/solver/nonlinear_gauss_seidel.hpp"

namespace talus {

namespace detail {
template <class Scenario>
struct world_state;
}

/// Velocities first, from forces and impulses; then positions from the new velocities.
struct semi_implicit_euler final {
  using talus_part_of = roles::integrator;
  static constexpr const char* name = "semi_implicit_euler";
  static constexpr bool shares_midway = false, at_midpoint = false;
  template <class Scenario>
  struct state {};
  template <class Scenario>
  static void step(detail::world_state<Scenario>& s);  // step/integrators/
};

/// Half of the change of velocity, positions with the velocity at mid-step, and from the forces
/// there the other half (Verlet 1967 in the form of Swope, Andersen, Berens, Wilson 1982). Second
/// order if forces depend on positions. For soft contacts: hard ones have impulses instead of
/// forces. Between steps shadow copies hold the velocity at mid-step.
struct velocity_verlet final {
  using talus_part_of = roles::integrator;
  static constexpr const char* name = "velocity_verlet";
  static constexpr bool shares_midway = true, at_midpoint = false;
  template <class Scenario>
  struct state {};
  template <class Scenario>
  static void step(detail::world_state<Scenario>& s);  // step/integrators/
};

/// Half of the motion with the old velocities, forces and contacts there, the other half with the
/// new velocities (Moreau 1999, with the impulses of the middle). Lasting contacts leave the
/// velocity that belongs to the end of the step instead of its middle (see
/// step/velocity_bias.hpp), so that rolling, spinning and precession are of second order in dt.
/// For hard contacts.
struct moreau_midpoint final {
  using talus_part_of = roles::integrator;
  static constexpr const char* name = "moreau_midpoint";
  static constexpr bool shares_midway = false, at_midpoint = true;
  template <class Scenario>
  struct state;
  template <class Scenario>
  static void step(detail::world_state<Scenario>& s);  // step/integrators/
};

/// Policy: the solver of the contact problem. Default: solver<nonlinear_gauss_seidel>. If a second
/// one is named, a program run by run() is compiled with both, and its option
/// --reproducible chooses the second: solver<nonlinear_gauss_seidel, reproducible>.
template <class Method, class OnRequest = void>
struct solver final {
  static_assert(std::is_void_v<OnRequest> || detail::solves_by_colours<OnRequest>,
                "solver<...> takes as second solver, for the option --reproducible, one whose "
                "results do not depend on the ranks: write solver<nonlinear_gauss_seidel, "
                "reproducible>");
  static_assert(detail::is_part<Method, roles::solver>,
                "solver<...> takes a solver, and this type is not one: write "
                "solver<nonlinear_gauss_seidel>, solver<coloured_gauss_seidel>, "
                "solver<accelerated_jacobi> or solver<substepping> (each in talus/solver/ under "
                "its name)");
  static_assert(!detail::is_part<Method, roles::solver> || concepts::solver<Method>,
                "solver<...> takes a solver, and this type lacks the static function "
                "solve(lists, state, settings, correct, ranks) or its name: see "
                "talus::concepts::solver");
  using talus_role = roles::solver;
  using type = Method;
  using on_request = OnRequest;
  static std::string describe() { return detail::describe_list<Method>("solver"); }
};

/// Policy: the time stepping. Default: integrator<semi_implicit_euler>.
template <class Method>
struct integrator final {
  static_assert(concepts::integrator<Method>,
                "integrator<...> takes an integrator, and this type is not one: write "
                "integrator<semi_implicit_euler>, or integrator<velocity_verlet> for soft "
                "contacts, or integrator<moreau_midpoint> for hard ones");
  using talus_role = roles::integrator;
  using type = Method;
  static std::string describe() { return detail::describe_list<Method>("integrator"); }
};

}  // namespace talus
