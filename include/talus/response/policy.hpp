#pragma once
// solver<...> and integrator<...>: how contact impulses are found, and how motion is stepped.
#include <type_traits>

#include "talus/core/policy.hpp"
#include "talus/response/nonlinear_gauss_seidel.hpp"

namespace talus {

/// Velocities first, from forces and impulses; then positions from the new velocities.
struct semi_implicit_euler final {
  using talus_part_of = roles::integrator;
  static constexpr const char* name = "semi_implicit_euler";
};

/// Half of the change of velocity, positions with the velocity at mid-step, and from the forces
/// there the other half (Verlet 1967 in the form of Swope, Andersen, Berens, Wilson 1982). Second
/// order where forces depend on positions. For soft contacts: hard ones have impulses, not forces.
/// Between steps shadow copies hold the velocity at mid-step.
struct velocity_verlet final {
  using talus_part_of = roles::integrator;
  static constexpr const char* name = "velocity_verlet";
};

/// Policy: the solver of the contact problem. Default: solver<nonlinear_gauss_seidel>.
template <class Method>
struct solver final {
  static_assert(detail::is_part<Method, roles::solver>,
                "solver<...> takes a solver, and this type is none: write "
                "solver<nonlinear_gauss_seidel>, solver<coloured_gauss_seidel>, "
                "solver<accelerated_jacobi> or solver<small_steps> (each in talus/response/ under "
                "its name)");
  using talus_role = roles::solver;
  using type = Method;
  static std::string describe() { return detail::describe_list<Method>("solver"); }
};

/// Policy: the time stepping. Default: integrator<semi_implicit_euler>.
template <class Method>
struct integrator final {
  static_assert(detail::is_part<Method, roles::integrator>,
                "integrator<...> takes an integrator, and this type is none: write "
                "integrator<semi_implicit_euler>, or integrator<velocity_verlet> for soft "
                "contacts");
  using talus_role = roles::integrator;
  using type = Method;
  static std::string describe() { return detail::describe_list<Method>("integrator"); }
};

}  // namespace talus
