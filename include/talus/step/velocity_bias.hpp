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
#include "talus/core/pack_vector.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/detect/sphere_batch.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/shape/frame.hpp"
#include "talus/state/state.hpp"
#include "talus/step/midpoint_state.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The square of the speed below which the accelerations that a bias compensates are less than 1e-4
/// of the acceleration `pull` of the bodies.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack slow_turn(const Pack& pull, const Pack& radius) {
  return every_lane<Pack>(1e-4) * pull * radius;
}

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
/// the normal at that time, and is `u` in the middle of this one; or of several contacts.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline vectors_of<Pack> midpoint_bias(
    const vectors_of<Pack>& normal, const vectors_of<Pack>& u, const vectors_of<Pack>& last_normal,
    const vectors_of<Pack>& last) {
  const Pack zero = every_lane<Pack>(0), one = every_lane<Pack>(1), two = every_lane<Pack>(2);
  const Pack un = dot(normal, u), half_change = (un - dot(last_normal, last)) / two;
  const Pack most = choose(un < zero, -un, un);
  const Pack half = larger(smaller(half_change, most), -most);
  const vectors_of<Pack> ut = u - un * normal;
  const Pack square = dot(ut, ut), part = dot(ut, u - last) / (two * square);
  const Pack share = choose(square > zero, larger(smaller(part, one), zero), zero);
  const Pack along = choose(half * un > zero, -half, zero);
  return along * normal - share * ut;
}

/// The biases of the pairs of a batch, between which accelerations of `pull` act: those of lasting
/// contacts whose bodies do not turn slowly.
template <bool Friction>
[[nodiscard]] inline pack_vector<wide_pack<real>> biases_of(const sphere_batch& of,
                                                            const wide_pack<real>& pull, real dt) {
  using wide = wide_pack<real>;
  const wide held = larger(pull * dt * dt, of.slack()), speed = of.speed();
  const auto turns = speed * speed >= slow_turn<wide>(pull, of.smaller_radius());
  const auto counts = (of.gap <= held) & turns;
  const pack_vector<wide> none{every_lane<wide>(0), every_lane<wide>(0), every_lane<wide>(0)};
  if (bits_of(counts) == 0) return none;
  const auto last = of.before(dt);
  pack_vector<wide> bias = midpoint_bias<wide>(of.normal, of.velocity, last.normal, last.velocity);
  if constexpr (!Friction) bias = dot(of.normal, bias) * of.normal;
  return choose(counts & (last.gap <= held) & (last.gap <= of.margin()), bias, none);
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

#pragma GCC diagnostic pop

}  // namespace talus::detail
