#pragma once
// The velocity bias of lasting contacts for integrator<moreau_midpoint>. Contacts are found in the
// middle of a step, and a rolling body satisfies G v = 0 there at neither end of it: while G
// changes by dG from one step to the next, G v is dG v / 2 before the impulses, and must be -dG v /
// 2 after them, so that the mean of both is zero, the step is symmetric in time, and contacts do no
// work (implicit midpoint rule). dG v follows from the geometry in the middle of the last step,
// which is recomputed.
//
// A bias is at most the relative velocity before the impulses, with the opposite sign: so contacts
// that are not in steady motion lose energy, and gain none.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/shape/frame.hpp"
#include "talus/state/state.hpp"
#include "talus/step/midpoint_state.hpp"

namespace talus::detail {

/// The contact points of one pair in the middle of the last step, and the velocities of its bodies
/// after that step.
class earlier_contacts {
 public:
  struct side {
    vec3 position{0, 0, 0}, v{0, 0, 0}, w{0, 0, 0};
  };
  void add(const contact_geometry& g) {
    if (size_ < most) points_[size_++] = g;
  }
  [[nodiscard]] const contact_geometry* find(std::uint64_t feature) const {
    for (std::size_t k = 0; k < size_; ++k)
      if (points_[k].feature == feature) return &points_[k];
    return nullptr;
  }
  void clear() { size_ = 0; }
  side a, b;

 private:
  static constexpr std::size_t most = 16;
  std::array<contact_geometry, most> points_;
  std::size_t size_ = 0;
};

/// The bias of a contact whose relative velocity was `last` at the middle of the last step, with
/// the normal at that time, and is `u` in the middle of this one.
[[nodiscard]] inline vec3 midpoint_bias(const vec3& normal, const vec3& u, const vec3& last_normal,
                                        const vec3& last) {
  const real un = normal.dot(u);
  const real dn = un - last_normal.dot(last);
  const real most = std::abs(un), half = std::clamp(dn / 2, -most, most);
  const vec3 ut = u - un * normal;
  vec3 bias{0, 0, 0};
  if (half * un > 0) bias = -half * normal;
  const real square = ut.squaredNorm();
  if (!(square > 0)) return bias;
  const real part = ut.dot(u - last) / (2 * square);
  return bias - std::clamp(part, real(0), real(1)) * ut;
}

/// The orientation of body i `dt` before, and its spin, if nothing acted on it since.
template <class Store>
void find_earlier_turn(earlier_turn& last, const Store& store, std::size_t i, real dt) {
  last = {store.orientation_of[i], store.angular_velocity[i], true};
  if (store.moves(i))
    last.spin = rotate_freely(last.orientation, last.spin, store.shape[i].inertia(), -dt);
}

/// The pose of a global body `dt` before, at its present velocity.
template <class Shape, class Store>
[[nodiscard]] std::pair<Shape, pose> global_before(const Store& store, std::size_t j, real dt) {
  Shape shape = store.shape[j];
  pose p = store.pose(j);
  const vec3 &v = store.velocity[j], &w = store.angular_velocity[j];
  const real speed = w.norm();
  const quat back = speed > 0 ? rotation(w, -dt * speed) : quat(1, 0, 0, 0);
  if constexpr (Shape::finite) {
    p.orientation = after(back, p.orientation);
    p.position -= dt * v;
  } else {
    shape.rotate(back, store.position[j]);
    shape.translate(-dt * v);
    p.position -= dt * v;
  }
  return {shape, p};
}

}  // namespace talus::detail
