#pragma once
// The attraction of touching bodies under normal_cohesion, applied before the contact problem.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A touching point of two bodies that attract each other. `normal` points towards a.
struct attraction {
  contact_key key;
  std::int32_t a = -1, b = -1;  ///< in the solver's arrays; b is -1 if it cannot move
  real force = 0;               ///< of the whole pair of bodies
  vec3 normal{0, 0, 0}, arm_a{0, 0, 0}, arm_b{0, 0, 0};
};

/// The attractions of a step. With r' = r + F_c dt n, the law of normal_cohesion for the impulse r
/// is Coulomb's law for r', and the velocities without r' are those without r, changed by -F_c dt
/// n. So this impulse is applied first, as that of a force, and every solver then finds r'.
class attractions {
 public:
  void clear() { all_.clear(); }
  void add(const attraction& x) { all_.push_back(x); }

  /// Shares the force of each pair equally among its points. The order of points is that of their
  /// keys, so that the sums of a body do not depend on the decomposition.
  void share() {
    std::sort(all_.begin(), all_.end(), [](const attraction& x, const attraction& y) {
      if (x.key.a != y.key.a) return x.key.a < y.key.a;
      if (x.key.b != y.key.b) return x.key.b < y.key.b;
      return x.key.feature < y.key.feature;
    });
    for (std::size_t first = 0, last = 0; first < all_.size(); first = last) {
      while (last < all_.size() && all_[last].key.same_pair(all_[first].key)) ++last;
      const real part = real{1} / static_cast<real>(last - first);
      for (std::size_t k = first; k < last; ++k) all_[k].force *= part;
    }
  }
  /// Calls f(body, impulse, its angular impulse) for both bodies of each point.
  template <class F>
  void each(real dt, F&& f) const {
    for (const attraction& x : all_) {
      const vec3 p = (-dt * x.force) * x.normal;
      f(static_cast<std::size_t>(x.a), p, vec3(x.arm_a.cross(p)));
      if (x.b >= 0) f(static_cast<std::size_t>(x.b), vec3(-p), vec3(-x.arm_b.cross(p)));
    }
  }

 private:
  plain_vector<attraction> all_;
};
struct no_attractions {};

/// Adds the attractions to the velocities after forces, and to the gain of solvers with substeps.
template <bool Divided, class Real>
void attract(attractions& all, solver_state_of<Real>& s, real dt) {
  all.share();
  all.each(dt, [&](std::size_t k, const vec3& p, const vec3& moment) {
    auto& body = s.bodies[k];
    if (body.inverse_mass == 0) return;
    const vec3 dv = static_cast<real>(body.inverse_mass) * p;
    const vec3 dw = k >= s.first_tensor ? vec3(s.tensor(k) * moment)
                                        : vec3(static_cast<real>(body.inverse_inertia) * moment);
    body.v += in_scalar<Real>(dv), body.w += in_scalar<Real>(dw);
    if constexpr (Divided) s.gain[k].v += dv, s.gain[k].w += dw;
  });
}

}  // namespace talus::detail
