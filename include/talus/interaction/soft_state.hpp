#pragma once
// The data of soft contacts: motion and forces of all bodies of this rank, of any shape.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "talus/core/exact_sum.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/interaction/local_curvature.hpp"
#include "talus/interaction/pair_parameters.hpp"

namespace talus::detail {

/// Motion of a body as used by its contacts, and the sum of their forces on it: two cache lines.
struct alignas(64) soft_body {
  vec3 v{0, 0, 0};
  real inverse_mass = 0;
  vec3 w{0, 0, 0};
  real radius = 0;  ///< of the sphere itself, or of one of equal volume
  vec3 force{0, 0, 0};
  real curvature = 0;  ///< 1 / radius
  vec3 torque{0, 0, 0};
  real contacts = 0;  ///< how many exert a force on it; counted for the residual monitor only
};

/// Where a body is, as used by the comparison of distances.
struct alignas(32) soft_place {
  vec3 position{0, 0, 0};
  real reach = 0;
};

/// The number of contacts, for observers; the contacts themselves are not kept.
struct soft_contacts {
  std::size_t here = 0;     ///< that count on this rank
  std::size_t doubled = 0;  ///< that count on another rank, which computes them too
  [[nodiscard]] std::size_t size() const { return here + doubled; }
  [[nodiscard]] std::size_t counted() const { return here; }
  [[nodiscard]] static std::size_t bytes() { return 0; }
};

template <class Law>
struct soft_state {
  plain_vector<soft_body> bodies;   ///< shape by shape, locals before shadow copies
  plain_vector<soft_place> places;  ///< likewise
  pair_parameters_of<typename Law::law> pairs;
  real fastest_approach = 0;  ///< along the normal of a contact, in steps of the present dt
  /// Sum over the contacts that count on this rank, in this step; for the residual monitor.
  exact_sum squares_of_forces;
  /// Longest stable step for the bonds when some were made, of all such moments.
  real step_of_bonds = std::numeric_limits<real>::infinity();
};

/// The radius that a shape has in the theory of spheres.
template <class Shape>
[[nodiscard]] real sphere_radius(const Shape& s) {
  if constexpr (Shape::isotropic)
    return s.bounding_radius();
  else
    return portable::cbrt(s.volume() * (3 / (4 * pi)));
}

/// A bound of the radius that a movable shape has at a contact.
template <class Shape>
[[nodiscard]] real widest_radius(const Shape& s) {
  if constexpr (has_curvatures<Shape>)
    return s.largest_curvature_radius();
  else
    return sphere_radius(s);
}

/// The radius that a Rayleigh wave runs around: the smallest of a body whose thickness differs.
template <class Shape>
[[nodiscard]] real wave_radius(const Shape& s) {
  if constexpr (requires { s.inner_radius(); })
    return s.inner_radius();
  else
    return sphere_radius(s);
}

/// The curvature that a wall has in the theory of spheres: faces are flat.
template <class Shape>
[[nodiscard]] real wall_curvature(const Shape& s) {
  if constexpr (Shape::isotropic)
    return 1 / s.bounding_radius();
  else
    return (void)s, 0;
}

}  // namespace talus::detail
