#pragma once
// Bodies with an inertia tensor rotate in groups.
#include <array>
#include <cstddef>

#include "talus/core/math.hpp"
#include "talus/motion/rotating_bodies.hpp"
#include "talus/step/finite_motion.hpp"

namespace talus::detail {

struct no_queue {};

/// Bodies of one store, rotated when a group is full. All rotate for the same time.
template <class Store>
class rotation_queue {
 public:
  /// Body i has the angular velocity `spin` before it rotates freely for the time `dt`, and then by
  /// the rotation vector `turn`.
  void add(Store& store, std::size_t i, const vec3& spin, const vec3& turn, real dt,
           finite_watch& watch) {
    rotating_body<real>& body = bodies_[count_];
    body.w = spin, body.turn = turn;
    body.inertia = store.shape[i].inertia();
    body.q = store.orientation_of[i];
    at_[count_++] = i;
    dt_ = dt;
    if (count_ == bodies_.capacity) finish(store, watch);
  }
  /// Rotates those that wait.
  void finish(Store& store, finite_watch& watch) {
    if (count_ == 0) return;
    bodies_.rotate(count_, dt_);
    for (std::size_t k = 0; k < count_; ++k) {
      vec3& w = store.angular_velocity[at_[k]];
      quat& q = store.orientation_of[at_[k]];
      w = bodies_[k].w, q = bodies_[k].q;
      watch.look(w), watch.look(q);
    }
    count_ = 0;
  }

 private:
  rotating_bodies<real> bodies_;
  std::array<std::size_t, rotating_bodies<real>::capacity> at_{};
  std::size_t count_ = 0;
  real dt_ = 0;
};

}  // namespace talus::detail
