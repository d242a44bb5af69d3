#pragma once
// The approach of the two bodies of a pair in this step: by their velocities, their rotation, their
// accelerations, and, if bodies are followed, their flight. A contact whose surfaces do not meet
// within the step must exert nothing. A gap that closes along its normal may belong to surfaces
// that pass each other: where the tangential way is larger than the slack, the path decides.
#include <algorithm>
#include <cstddef>
#include <type_traits>

#include "talus/detect/narrow.hpp"
#include "talus/detect/nearest_approach.hpp"
#include "talus/features/continuous_collision/continuous.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

template <class Shape>
inline constexpr bool has_round_ends =
    std::is_same_v<Shape, sphere> || std::is_same_v<Shape, capsule>;

/// Whether the bodies of a pair come within the slack on their paths.
enum class path : char { unknown, meet, pass };

/// The surfaces of a shape without edges or flat parts, by their radii of curvature.
template <class Shape>
concept is_smooth = std::is_same_v<Shape, sphere> || requires(const Shape& s) {
  s.smallest_curvature_radius();
  s.largest_curvature_radius();
};
template <is_smooth Shape>
[[nodiscard]] real smallest_curvature(const Shape& s) {
  if constexpr (std::is_same_v<Shape, sphere>)
    return s.radius;
  else
    return s.smallest_curvature_radius();
}
template <is_smooth Shape>
[[nodiscard]] real largest_curvature(const Shape& s) {
  if constexpr (std::is_same_v<Shape, sphere>)
    return s.radius;
  else
    return s.largest_curvature_radius();
}

/// The motion of the pairs of two shapes within a step. The second bodies are movable too
/// (`Paired`), or are global and may be driven.
template <class Scenario, class ShapeA, class ShapeB, bool Paired>
class pair_motion {
  using state_type = world_state<Scenario>;
  using law = typename state_type::law;
  using store_a = body_store<ShapeA, typename Scenario::features>;
  using store_b = body_store<ShapeB, typename Scenario::features>;
  static constexpr bool driven = !Paired && state_type::drives;
  static constexpr bool two_spheres =
      std::is_same_v<ShapeA, sphere> && std::is_same_v<ShapeB, sphere>;

 public:
  pair_motion(const state_type& s, const store_a& a, const store_b& b)
      : s_(s),
        a_(a),
        b_(b),
        first_a_(s.template of<ShapeA>().first),
        first_b_(Paired ? s.template of<ShapeB>().first : 0),
        gravity_(s.gravity.norm()) {}

  /// A contact with a gap above the slack that does not close within the step is left out. `u` is
  /// its relative velocity; `radius` that of the first body.
  [[nodiscard]] bool parts_before_touching(std::size_t i, std::size_t j, real radius, real slack,
                                           const contact_geometry& g, const vec3& u) const {
    if (g.gap <= slack) return false;
    real closing = g.normal.dot(u) * s_.dt - 2 * gravity_ * s_.dt * s_.dt;
    closing -= way_of_turning(a_, i, s_.dt);
    if constexpr (Paired) closing -= way_of_turning(b_, j, s_.dt);
    if constexpr (driven) closing -= b_.angular_velocity[j].norm() * radius * s_.dt;
    return g.gap + closing > slack;
  }
  /// Whether bodies with such a normal and gap, now at these places, may pass each other: their gap
  /// closes in this step, by the velocity `un` along the normal and the acceleration `pull`, and
  /// they move so far along the surfaces that their paths decide. They may not if a third body that
  /// takes this motion would leave one on the wrong side of the other.
  [[nodiscard]] bool may_pass(std::size_t i, std::size_t j, const vec3& at_a, const vec3& at_b,
                              real slack, const vec3& normal, real gap, real un, real pull) const {
    if constexpr (!ShapeB::finite || state_type::continuous) {
      return false;
    } else {
      if (gap <= touching_part * slack) return false;
      if (gap <= slack && !(gap + (un - pull * s_.dt) * s_.dt < 0)) return false;
      const vec3 way = way_past(i, j, at_a, at_b);
      const real turning = way_of_turning(a_, i, s_.dt) + way_of_turning(b_, j, s_.dt);
      if ((way - normal.dot(way) * normal).norm() + turning <= meeting_gap(way, slack))
        return false;
      return gap + normal.dot(way) - gravity_ * s_.dt * s_.dt >=
             -reversing_overlap(a_.shape[i], b_.shape[j]);
    }
  }
  /// Whether bodies with this contact meet in this step, as far as their velocities there tell;
  /// else meet_on_paths() does. They meet if balls inside both, which touch their surfaces there,
  /// come near: one of the smallest radius of curvature fits everywhere (Blaschke, "Kreis und
  /// Kugel", 1916). They pass each other if the plane between them separates them all the time.
  [[nodiscard]] path path_by_contact(std::size_t i, std::size_t j, const vec3& at_a,
                                     const vec3& at_b, real slack,
                                     const contact_geometry& g) const {
    if constexpr (!is_smooth<ShapeA> || !is_smooth<ShapeB> || driven || two_spheres) {
      return path::unknown;  // (of two spheres meet_on_paths() is as fast)
    } else {
      const ShapeA& a = a_.shape[i];
      const ShapeB& b = b_.shape[j];
      const vec3 turn_a = s_.dt * a_.angular_velocity[i], turn_b = s_.dt * b_.angular_velocity[j];
      const vec3 centres = way_past(i, j, at_a, at_b);
      // The path of a point of a rotating body is an arc, and the axis may turn too.
      const real bent_a = turn_a.squaredNorm(), bent_b = turn_b.squaredNorm();
      const vec3 arm_a = g.point + real(0.5) * g.gap * g.normal - at_a;
      const vec3 arm_b = g.point - real(0.5) * g.gap * g.normal - at_b;
      const auto way = [&](const vec3& a, const vec3& b) -> vec3 {
        return centres + turn_a.cross(a) - turn_b.cross(b);
      };
      const real touch = meeting_gap(centres, slack);
      const real nearest = g.gap + std::min(real(0), g.normal.dot(way(arm_a, arm_b))) -
                           bent_a * (a.bounding_radius() + largest_curvature(a)) -
                           bent_b * (b.bounding_radius() + largest_curvature(b));
      if (nearest > touch) return path::pass;
      const real ball_a = smallest_curvature(a), ball_b = smallest_curvature(b);
      const vec3 in_a = arm_a + ball_a * g.normal, in_b = arm_b - ball_b * g.normal;
      const real reach = ball_a + ball_b + touch - bent_a * in_a.norm() - bent_b * in_b.norm();
      const bool meet =
          reach > 0 && points_come_near(at_a + in_a - (at_b + in_b), way(in_a, in_b), reach);
      return meet ? path::meet : path::unknown;
    }
  }
  /// Whether they meet on their paths in this step, as the integrator moves them without contacts.
  [[nodiscard]] bool meet_on_paths(std::size_t i, std::size_t j, const vec3& at_a, const vec3& at_b,
                                   real slack) const {
    if constexpr (!ShapeB::finite) {
      return true;
    } else if constexpr (two_spheres) {
      const vec3 way = way_past(i, j, at_a, at_b);
      return points_come_near(at_a - at_b, way,
                              a_.shape[i].radius + b_.shape[j].radius + meeting_gap(way, slack));
    } else {
      const real touch = meeting_gap(way_past(i, j, at_a, at_b), slack);
      auto fa = path_of(a_, i, at_a);
      auto fb = path_of(b_, j, at_b);
      fa.coarse = part_of_touch * touch / a_.shape[i].bounding_radius();
      fb.coarse = part_of_touch * touch / b_.shape[j].bounding_radius();
      if constexpr (driven)
        if (const driven_body* one = going_body<ShapeB>(s_, j))
          return come_near(a_.shape[i],
                           moving_frame(fa, one->state.at.point, one->next.v, one->next.w, s_.dt),
                           b_.shape[j], fb, s_.dt, touch);
      return come_near(a_.shape[i], fa, b_.shape[j], fb, s_.dt, touch);
    }
  }
  [[nodiscard]] real gravity() const { return gravity_; }
  /// How far both may move in this step, in sum.
  [[nodiscard]] real margin_in_step(std::size_t i, std::size_t j) const {
    return margin_of(a_, i) + margin_of(b_, j);
  }
  /// Acceleration of the surfaces by gravity and by the forces and torques on the two bodies.
  [[nodiscard]] real pull(std::size_t i, std::size_t j) const {
    real sum = gravity_;
    if constexpr (store_a::forced) sum += pull_on(a_, i);
    if constexpr (Paired && store_b::forced) sum += pull_on(b_, j);
    return sum;
  }
  /// The part of it by which they approach; zero for bodies at their impact, whose velocities are
  /// true.
  [[nodiscard]] real fall(std::size_t i, std::size_t j, const vec3& normal) const {
    vec3 a = acceleration_of(s_, a_, i);
    if constexpr (Paired) a -= acceleration_of(s_, b_, j);
    if constexpr (state_type::continuous) {
      if (impact_time(first_a_ + i) != never) return 0;
      if constexpr (Paired)
        if (impact_time(first_b_ + j) != never) return 0;
    }
    return (void)j, -normal.dot(a);
  }
  /// Whether one of two bodies that are followed has an impact in this step.
  [[nodiscard]] bool strikes(std::size_t i, std::size_t j) const {
    if constexpr (state_type::continuous) {
      if (impact_time(first_a_ + i) != never) return true;
      if constexpr (Paired) return impact_time(first_b_ + j) != never;
    }
    return (void)i, (void)j, false;
  }

  // Where bodies are followed.

  /// Separated bodies that were followed and do not meet in this step. (If one of them had an
  /// impact, its path changes: as without continuous collision, it must not enter the other, unless
  /// that would be a rebound at a distance.)
  [[nodiscard]] bool not_met(std::size_t i, std::size_t j, real gap,
                             const pair_material& pair) const {
    const real zone = contact_zone(a_.shape[i], b_.shape[j]);
    if (gap <= zone) return false;
    real way = way_of(s_, a_, i);
    bool struck = impact_time(first_a_ + i) != never;
    if constexpr (Paired) {
      way += way_of(s_, b_, j);
      struck = struck || impact_time(first_b_ + j) != never;
    } else {
      way += way_of_driven<ShapeB>(s_, a_, i, j);
    }
    return way > slow_way(s_, zone) && !(struck && !(law::restitution && pair.restitution > 0));
  }
  /// Converts a relative velocity to that at the impact.
  void add_flight(vec3& u, std::size_t i, std::size_t j) const {
    u += flown(a_, i, first_a_);
    if constexpr (Paired) u -= flown(b_, j, first_b_);
  }
  /// Converts the normal velocity after the impact to that at the end of the step. (A solver with
  /// substeps computes that itself.)
  void add_flight_after(real& target, std::size_t i, std::size_t j, const vec3& normal) const {
    if constexpr (uses_substeps<typename Scenario::solver>) return;
    const bool rebounds = target > 0;
    target += normal.dot(to_fly(a_, i, first_a_, rebounds));
    if constexpr (Paired) target -= normal.dot(to_fly(b_, j, first_b_, rebounds));
  }

 private:
  /// The error of a path by its rotation, over the gap at which surfaces touch.
  static constexpr real part_of_touch = 0.1;

  /// The overlap from which on the normal of two bodies may point to the other side: the centre of
  /// a sphere, or the axis of a capsule, enters the other body; else half of the thinner body. It
  /// is at most the size of the smaller one.
  [[nodiscard]] static real reversing_overlap(const ShapeA& a, const ShapeB& b) {
    constexpr bool round_a = has_round_ends<ShapeA>, round_b = has_round_ends<ShapeB>;
    if constexpr (!round_a && !round_b) {
      return std::min(inner_radius(a), inner_radius(b));
    } else {
      real overlap = 2 * std::min(a.bounding_radius(), b.bounding_radius());
      if constexpr (!round_b) overlap = std::min(overlap, a.radius);
      if constexpr (!round_a) overlap = std::min(overlap, b.radius);
      if constexpr (round_a && round_b) overlap = std::min(overlap, a.radius + b.radius);
      return overlap;
    }
  }
  /// Surfaces that come nearer than this on their paths meet. The path of a body that is no faster
  /// than gravity makes it in two steps depends on its other contacts, so that a near miss of such
  /// bodies counts as a touch. So does one of two spheres, which have no edges that fling them
  /// aside.
  [[nodiscard]] real meeting_gap(const vec3& way, real slack) const {
    const bool slow = two_spheres || way.norm() <= 2 * gravity_ * s_.dt * s_.dt;
    return (slow ? touching_part : real(0.01) * touching_part) * slack;
  }
  /// The straight path of a body from `at` in this step. (Rotation by torques in the step is
  /// neglected.)
  template <class Store>
  [[nodiscard]] auto path_of(const Store& store, std::size_t i, const vec3& at) const {
    auto f = flight_of(s_, store, i);
    f.position = at;
    if (store.inverse_mass[i] == 0) return f;
    constexpr bool divided = uses_substeps<typename Scenario::solver>;
    const real gained = divided ? real(0.5) * s_.dt + half_part(s_) : s_.dt;  // in the mean
    f.velocity = store.velocity[i] + gained * f.acceleration;
    f.acceleration = {0, 0, 0};
    if (s_.damping != 1) f.velocity *= kept_by_damping(s_);
    return f;
  }
  /// How far the first body moves in this step relative to the second, at its centre.
  [[nodiscard]] vec3 way_past(std::size_t i, std::size_t j, const vec3& at_a,
                              const vec3& at_b) const {
    vec3 v = path_of(a_, i, at_a).velocity - path_of(b_, j, at_b).velocity;
    if constexpr (driven)
      if (const driven_body* one = going_body<ShapeB>(s_, j))
        v -= one->next.v + one->next.w.cross(at_a - one->state.at.point);
    return s_.dt * v;
  }
  [[nodiscard]] real impact_time(std::size_t body) const { return s_.impacts.time[body]; }
  /// The true velocity of a body at its impact minus the stored one.
  template <class Store>
  [[nodiscard]] vec3 flown(const Store& store, std::size_t i, std::size_t first) const {
    const real t = impact_time(first + i);
    if (t == never) return {0, 0, 0};
    return (half_part(s_) + t) * acceleration_of(s_, store, i);
  }
  /// The true velocity of a body at the end of the step minus the velocity after its impact. A body
  /// that rebounds flies on; another one stays.
  template <class Store>
  [[nodiscard]] vec3 to_fly(const Store& store, std::size_t i, std::size_t first,
                            bool rebounds) const {
    const real t = impact_time(first + i);
    if (t == never) return {0, 0, 0};
    const vec3 a = acceleration_of(s_, store, i);
    if constexpr (state_type::midpoint) return (rebounds ? s_.dt - t : real(0.5) * (s_.dt - t)) * a;
    return (rebounds ? real(0.5) * s_.dt - t : real(-0.5) * t) * a;
  }
  template <class Store>
  [[nodiscard]] real margin_of(const Store& store, std::size_t i) const {
    if constexpr (Store::shape_type::finite)
      return reach_of(store, i, s_.dt) - store.shape[i].bounding_radius();
    else
      return (void)store, (void)i, 0;
  }
  template <class Store>
  [[nodiscard]] static real pull_on(const Store& s, std::size_t i) {
    const real arm = s.shape[i].bounding_radius() / s.shape[i].inertia().minCoeff();
    return s.inverse_mass[i] * (s.force[i].norm() + arm * s.torque[i].norm());
  }

  const state_type& s_;
  const store_a& a_;
  const store_b& b_;
  std::size_t first_a_, first_b_;
  real gravity_;
};

}  // namespace talus::detail
