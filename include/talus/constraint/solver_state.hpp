#pragma once
// The data of a contact solver: the velocities of all bodies of this rank, of any shape, gathered
// into one array at the beginning of the response and scattered at its end.
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/constraint/body_groups.hpp"
#include "talus/constraint/impact_stage.hpp"
#include "talus/constraint/island_budget.hpp"
#include "talus/constraint/island_limits.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Velocity and inverse inertia of one body: one cache line, or half of one. For a body whose
/// inertia is a tensor `inverse_inertia` is 0; see solver_state::tensors.
template <class Real>
struct alignas(8 * sizeof(Real)) solver_body_of {
  vector3<Real> v{0, 0, 0};
  Real inverse_mass = 0;
  vector3<Real> w{0, 0, 0};
  Real inverse_inertia = 0;
};
using solver_body = solver_body_of<real>;

/// Displacement of a body per unit of time by the position correction.
template <class Real>
struct alignas(4 * sizeof(Real)) body_shift_of {
  vector3<Real> v{0, 0, 0};
  Real inverse_mass = 0;
};
using body_shift = body_shift_of<real>;

/// Rotation of a body per unit of time by the position correction. It is as large as four numbers,
/// so that packs can read it as such.
struct alignas(32) body_turn {
  vec3 w{0, 0, 0};
  real none = 0;
};

/// Velocities of a body, or changes of them.
struct body_motion {
  vec3 v{0, 0, 0}, w{0, 0, 0};
};

/// The orientation of a body whose moments of inertia differ, if the solver rotates it in the
/// course of a step.
struct rotated_body {
  quat orientation{1, 0, 0, 0};
  vec3 inertia{0, 0, 0};  ///< principal moments, over the mass
  real time = 0;          ///< of a substep; 0 for a body that the solver does not rotate
  real waiting = 0;       ///< time for which it is still to be rotated, without the last substep
  // By contacts and joints, over the mass:
  vec3 angular_impulse{0, 0, 0};
  real work = 0;
  vec3 spin{0, 0, 0};  ///< after them

  /// The angular momentum at an angular velocity, over the mass.
  [[nodiscard]] vec3 momentum(const vec3& w) const {
    return orientation * vec3(inertia.cwiseProduct(orientation.conjugate() * w));
  }
};
/// Whether the energy of a body at a given angular velocity depends on its orientation.
[[nodiscard]] inline bool has_unequal_moments(const vec3& inertia) {
  return inertia.maxCoeff() > (1 + real(1e-12)) * inertia.minCoeff();
}

/// A solver with substeps, so that positions follow more velocities than the last one.
template <class Solver>
inline constexpr bool uses_substeps = requires {
  requires Solver::uses_substeps;
};

/// A solver that solves small groups of contacts across ranks as one problem; see
/// shared_islands.hpp.
template <class Solver>
inline constexpr bool solves_shared_islands = requires {
  requires Solver::solves_shared_islands;
};

/// A solver that sweeps colour by colour, so that nothing depends on the order of contacts in
/// memory; see coloured_gauss_seidel.hpp.
template <class Solver>
inline constexpr bool solves_by_colours = requires {
  requires Solver::by_colours;
};

/// Stands for two solvers, of which each run uses one: the second for the option --reproducible.
template <class First, class Second>
struct either_solver {};

/// Bodies in the order of the shapes of the scenario, those with scalar inertia before those with a
/// tensor, locals before shadow copies within each shape. `Real` is the scalar of velocities and of
/// the impulses of isotropic contacts; see precision<...>. Further data of bodies with a tensor are
/// always real.
template <class Real>
struct solver_state_of {
  using number = Real;

  plain_vector<solver_body_of<Real>> bodies;
  /// The shift of each body, which moves positions and never enters the velocities. Empty without
  /// position correction.
  plain_vector<body_shift_of<Real>> shift;
  plain_vector<body_turn> turn;  ///< likewise the rotation, of bodies from first_tensor
  plain_vector<mat3> tensors;    ///< inverse inertia, world frame, of bodies from first_tensor
  std::size_t first_tensor = 0;
  std::size_t first_global = ~std::size_t{0};  ///< from there on bodies are global and immovable
  /// Number of bodies on other ranks that a body touches; only with several ranks.
  plain_vector<std::uint32_t> boundary_contacts;
  real speed = 0;         ///< a relevant change of velocity: the gain by gravity in a step
  vec3 fall{0, 0, 0};     ///< the gain of velocity by gravity in a step
  bool impacts = false;   ///< a contact of this step is an impact that rebounds
  bool rebounds = false;  ///< a material has restitution
  bool finishes = false;  ///< impacts are solved to round-off
  impact_stage stage = impact_stage::none;
  bool impacts_ended = false;  ///< impulses of contacts contain those that are held
  island_budget islands;
  island_limits limits;
  body_groups groups;
  plain_vector<std::uint32_t> gathered;  ///< bodies whose islands one rank solves for several
  plain_vector<std::uint32_t> jointed;   ///< bodies whose joints are solved all at once

  // For solvers with substeps; empty with others.
  plain_vector<body_motion> gain;      ///< gain of the velocities by forces in the step
  plain_vector<body_motion> drift;     ///< mean velocity of the step, minus the one at its end
  plain_vector<rotated_body> rotated;  ///< bodies from first_tensor, as the last substep begins

  /// The orientation of a body that the solver rotates; null for other bodies.
  [[nodiscard]] const rotated_body* rotated_at(std::size_t body) const {
    const std::size_t k = body - first_tensor;
    return body >= first_tensor && k < rotated.size() && rotated[k].time > 0 ? &rotated[k]
                                                                             : nullptr;
  }
  [[nodiscard]] rotated_body* rotated_at(std::size_t body) {
    return const_cast<rotated_body*>(std::as_const(*this).rotated_at(body));
  }
  [[nodiscard]] const mat3& tensor(std::size_t body) const { return tensors[body - first_tensor]; }
  /// Bodies of other ranks whose contacts this rank solves too follow all others, with either kind
  /// of inertia.
  [[nodiscard]] bool has_tensor(std::size_t body) const {
    return body >= first_tensor && body - first_tensor < tensors.size() &&
           bodies[body].inverse_inertia == 0;
  }
};
using solver_state = solver_state_of<real>;

/// Velocities of a body as reals, from any stored type.
template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline decltype(auto) v_of(const solver_body_of<Real>& b) {
  return in_scalar<real>(b.v);
}
template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline decltype(auto) w_of(const solver_body_of<Real>& b) {
  return in_scalar<real>(b.w);
}

}  // namespace talus::detail
