#pragma once
// Motion that is no longer finite ends the run in that step, with the id of the body, before it
// affects anything else.
#include <cmath>
#include <string>
#include <type_traits>

#include "talus/core/error.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Tests numbers as they are written, at the cost of one addition each: the sum of their products
/// with 0 is 0 as long as all are finite (and their sums).
class finite_watch {
 public:
  void look(const vec3& v) { sum_ += 0 * (v[0] + v[1] + v[2]); }
  void look(const quat& q) { sum_ += 0 * (q.w() + q.x() + q.y() + q.z()); }
  [[nodiscard]] bool doubtful() const { return !(sum_ == 0); }

 private:
  real sum_ = 0;
};

/// Throws runtime_error for the first body owned here whose motion is not finite.
template <class Scenario, class Store>
[[gnu::cold, gnu::noinline]] void refuse_infinite_motion(const world_state<Scenario>& s,
                                                         const Store& store) {
  for (std::size_t i = 0; i < store.locals; ++i) {
    const char* what = nullptr;
    std::string value;
    const auto look = [&](const char* name, const vec3& v) {
      if (what == nullptr && !finite(v)) what = name, value = text(v);
    };
    look("velocity", store.velocity[i]);
    look("angular velocity", store.angular_velocity[i]);
    look("position", store.position[i]);
    if constexpr (Store::oriented) {
      const quat& q = store.orientation_of[i];
      look("orientation", q.vec() + thrice<real>(q.w()));
    }
    if (what == nullptr) continue;
    fail<std::runtime_error>(
        "the {} of body {} ({}) on rank {} is no longer finite in step {}: {}, at {}, with dt = "
        "{}; "
        "choose a smaller dt, or look for forces, speeds or ratios of mass beyond all measure, or "
        "for bodies deep in each other at the start",
        what, store.id[i], Store::shape_type::name, s.link->rank(), s.steps, value,
        store.position[i], s.dt);
  }
}

}  // namespace talus::detail
