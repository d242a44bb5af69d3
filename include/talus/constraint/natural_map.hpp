#pragma once
// The deviation of an impulse and a velocity from Coulomb's law: the natural map of the cone
// problem.
#include <cmath>

#include "talus/core/math.hpp"

namespace talus::detail {

/// The point of the cone |r_t| <= mu r_n nearest to `r`; `n` is the cone's unit axis. With mu = 0
/// the cone is the half-line along n.
[[nodiscard]] inline vec3 nearest_in_cone(const vec3& r, const vec3& n, real mu) {
  const real along = n.dot(r);
  const vec3 across = r - along * n;
  const real length = across.norm();
  if (along >= 0 && length <= mu * along) return r;
  if (mu * length <= -along) return {0, 0, 0};
  const real height = (along + mu * length) / (1 + mu * mu);
  if (length == 0) return height * n;
  return height * (n + (mu / length) * across);
}

/// r - P_K(r - rho u^), zero if Coulomb's law holds: De Saxce's form u^ = u + mu |u_t| n makes it
/// one cone condition (Acary, Bremond, Huber 2018). `u` is the relative velocity minus the target
/// of the law along the normal; `rho` has the unit of a mass.
[[nodiscard]] inline vec3 natural_map(const vec3& r, const vec3& u, const vec3& n, real mu,
                                      real rho) {
  const real slip = mu == 0 ? 0 : (u - n.dot(u) * n).norm();
  return r - nearest_in_cone(r - rho * (u + mu * slip * n), n, mu);
}

}  // namespace talus::detail
