#pragma once
// features<continuous_collision>: a body with an impact in a step is first moved to the time of its
// first impact in that step. Contacts are found and solved there, with the true normal and no
// contacts at a distance. The body moves through the rest of the step with its new velocity, but
// only until its next impact, and by at most half its inner radius, beyond which nothing was
// tested. So nothing tunnels, however thin, nothing deflects a body that only passes by, and bodies
// rebound where they meet. All this is for bodies faster than the gain by gravity in a step or two;
// slower ones are in contact, or nearly so.
//
// A driven body (features<driven>) moves through the whole step. Impacts with it are computed in
// the frame that moves with it, and a stopped body in its way is carried along.
//
// A solver with substeps divides the remaining step of each body: of a body that was moved to its
// impact, the rest of the step, in which it gains the rest of the velocity from gravity and forces.
//
// With the midpoint, a velocity is the true one at the end of a step, and contacts are searched at
// poses in the middle of the step. Flights pass through these, but last from the start of the step
// to its end, damped as the integrator damps them. A body that is not faster than bodies at rest
// has its contacts in the middle of the step, as without continuous collision.
#include <algorithm>
#include <cmath>
#include <vector>

#include "talus/detect/narrow.hpp"
#include "talus/detect/time_of_impact.hpp"
#include "talus/features/energy_ledger/energy_ledger.hpp"
#include "talus/ghosts/shadow_copies.hpp"
#include "talus/ghosts/shared_velocities.hpp"
#include "talus/motion/free_flight.hpp"
#include "talus/motion/moving_frame.hpp"
#include "talus/pairs/flush_surface.hpp"
#include "talus/pairs/shape_pairs.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Acceleration of a body by gravity and the forces on it.
template <class Store>
[[nodiscard]] vec3 acceleration_of(const step_conditions& s, const Store& store, std::size_t i) {
  if (!store.moves(i)) return {0, 0, 0};
  vec3 a = s.gravity;
  if constexpr (Store::forced) a += store.inverse_mass[i] * store.force[i];
  return a;
}

/// Half of the step, or of its first substep: a velocity is the true one that much earlier. With
/// the midpoint it is the true one.
template <class Scenario>
[[nodiscard]] real half_part(const world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::midpoint)
    return (void)s, 0;
  else if constexpr (uses_substeps<typename Scenario::solver>)
    return real(0.5) * s.dt / s.settings.iterations;
  else
    return real(0.5) * s.dt;
}

/// The time in the step at which bodies have the poses with which contacts are searched.
template <class Scenario>
[[nodiscard]] real time_of_poses(const world_state<Scenario>& s) {
  return world_state<Scenario>::midpoint ? real(0.5) * s.dt : real(0);
}

/// The flight of a body from its present pose on. (Rotation by torques in the step is neglected.)
template <class Scenario, class Store>
[[nodiscard]] auto flight_of(const world_state<Scenario>& s, const Store& store, std::size_t i) {
  free_flight<Store::tensor> f;
  f.position = store.position[i];
  f.orientation = store.pose(i).orientation;
  if (store.inverse_mass[i] == 0) return f;
  f.acceleration = acceleration_of(s, store, i);
  f.velocity = store.velocity[i] + half_part(s) * f.acceleration;
  if constexpr (Store::tensor) {
    f.spin = store.angular_velocity[i];
    f.inertia = store.shape[i].inertia();
  }
  return f;
}

/// The flight of a body in this step that passes through the position `at` at time_of_poses(). With
/// the midpoint it has the positions and velocities of a step without contacts at both ends.
template <class Scenario, class Store>
[[nodiscard]] auto flight_through(const world_state<Scenario>& s, const Store& store, std::size_t i,
                                  const vec3& at) {
  auto f = flight_of(s, store, i);
  f.position = at;
  if constexpr (world_state<Scenario>::midpoint) {
    if (store.inverse_mass[i] == 0) return f;
    if (const real kept = kept_by_damping(s); kept != 1) {
      const vec3 end = kept * (f.velocity + s.dt * f.acceleration);
      f.velocity /= kept, f.spin /= kept, f.later = kept * kept;
      f.acceleration = (end - f.velocity) / s.dt;
    }
    f.position -= time_of_poses(s) * f.velocity, f.turned = time_of_poses(s);
  }
  return f;
}

/// How far a point of a body can move in this step.
template <class Scenario, class Store>
[[nodiscard]] real way_of(const world_state<Scenario>& s, const Store& store, std::size_t i) {
  if (store.inverse_mass[i] == 0) return 0;
  real speed = store.velocity[i].norm() + s.dt * acceleration_of(s, store, i).norm();
  if constexpr (Store::tensor)
    speed += store.shape[i].bounding_radius() * store.angular_velocity[i].norm();
  if constexpr (world_state<Scenario>::midpoint)  // they are damped already
    if (s.damping != 1) speed /= kept_by_damping(s);
  return s.dt * speed;
}

/// Radius of the ball about the centre that fits into a convex shape, or an estimate of it. A
/// surface has no inside: what is beyond it is told by the centre of the other body alone.
template <class Shape>
[[nodiscard]] real inner_radius(const Shape& shape) {
  if constexpr (requires { shape.least_extent(); }) {
    return shape.least_extent();
  } else if constexpr (Shape::isotropic) {
    return shape.bounding_radius();
  } else if constexpr (is_triangulated<Shape>) {
    return never;
  } else {
    real least = never;
    for (int axis = 0; axis < 3; ++axis)
      for (const real sign : {-1., 1.})
        least = std::min(least, sign * shape.support(sign * vec3::Unit(axis))[axis]);
    return least;
  }
}

/// Slack within which two bodies are in contact: contact_slack of the smaller one, for each.
template <class A, class B>
[[nodiscard]] real contact_zone(const A& a, const B& b) {
  if constexpr (B::finite)
    return 2 * contact_slack * std::min(a.bounding_radius(), b.bounding_radius());
  else
    return contact_slack * a.bounding_radius();
}

/// A distance per step up to which a body counts as slow.
[[nodiscard]] inline real slow_way(const step_conditions& s, real zone) {
  return 3 * s.gravity.norm() * s.dt * s.dt + real(1e-3) * zone;
}

/// The definition of an impact of two shapes.
template <class Scenario, class A, class B>
[[nodiscard]] impact_search search_for(const world_state<Scenario>& s, const A& a, const B& b) {
  real thickness = inner_radius(a), size = a.bounding_radius();
  if constexpr (B::finite) {
    thickness = std::min(thickness, inner_radius(b));
    size = std::min(size, b.bounding_radius());
  }
  return {.from = 0,
          .to = s.dt,
          .touch = real(1e-6) * size,
          .zone = contact_zone(a, b),
          .rest = 2 * s.gravity.norm() * s.dt,
          .plunge = real(0.5) * thickness,
          .at_once = world_state<Scenario>::midpoint};
}

/// The driven body of global body j of a shape if it moves in this step, or null. (A belt has a
/// velocity, but stays.)
template <class Shape, class Scenario>
[[nodiscard]] const driven_body* going_body(const world_state<Scenario>& s, std::size_t j) {
  if constexpr (world_state<Scenario>::drives) {
    const driven_body* one = driven_at<Shape>(s, j);
    if (one != nullptr && !(one->next.end == one->state.at)) return one;
  }
  return (void)s, (void)j, nullptr;
}

/// How far the surface of a global body moves in this step near body i.
template <class Shape, class Scenario, class Store>
[[nodiscard]] real way_of_driven(const world_state<Scenario>& s, const Store& store, std::size_t i,
                                 std::size_t j) {
  const driven_body* one = going_body<Shape>(s, j);
  if (one == nullptr) return 0;
  const real arm =
      (store.position[i] - one->state.at.point).norm() + store.shape[i].bounding_radius();
  return s.dt * (one->next.v.norm() + arm * one->next.w.norm());
}

/// Whether two bodies meet at time t on a flush surface only where contacts are hidden, or where
/// they slide along it.
template <class ShapeB, bool Paired, class Scenario, class StoreA, class FlightA, class StoreB,
          class FlightB>
[[nodiscard]] bool meet_hidden(world_state<Scenario>& s, const StoreA& a, std::size_t i,
                               const FlightA& fa, const StoreB& b, std::size_t j, const FlightB& fb,
                               const impact_search& search, real t) {
  using ShapeA = typename StoreA::shape_type;
  if (!is_beside_flush<ShapeA, ShapeB, Paired>(s, a, i, b, j)) return false;
  const pose at_a = fa.at(t), at_b = fb.at(t);
  const vec3 v = fa.speed(t) - fb.speed(t);
  bool some = false, shown = false;
  collide_pair(a.shape[i], at_a, b.shape[j], at_b, search.zone, [&](const contact_geometry& g) {
    some = true;
    const vec3 u =
        v + fa.spin.cross(g.point - at_a.position) - fb.spin.cross(g.point - at_b.position);
    shown = shown ||
            (-g.normal.dot(u) > search.rest &&
             !is_hidden<ShapeA, ShapeB, Paired>(s, a, i, at_a.position, b, j, at_b.position, g));
  });
  return some && !shown;
}

/// The time at which two bodies meet, elsewhere than at hidden contacts. The impact with a driven
/// body is computed in the frame that moves with it: there it stands still, and the other body
/// flies along a curve.
template <class ShapeB, bool Paired, class Scenario, class StoreA, class FlightA, class StoreB,
          class FlightB>
[[nodiscard]] real meeting_of(world_state<Scenario>& s, const StoreA& a, std::size_t i,
                              const FlightA& fa, const StoreB& b, std::size_t j, const FlightB& fb,
                              impact_search search) {
  const auto& shape = a.shape[i];
  if constexpr (!Paired && world_state<Scenario>::drives)
    if (const driven_body* one = going_body<ShapeB>(s, j))
      return time_of_impact(shape,
                            moving_frame(fa, one->state.at.point, one->next.v, one->next.w,
                                         search.to, time_of_poses(s)),
                            b.shape[j], fb, search);
  while (true) {
    const real t = time_of_impact(shape, fa, b.shape[j], fb, search);
    if (t == never || !meet_hidden<ShapeB, Paired>(s, a, i, fa, b, j, fb, search, t)) return t;
    search.from = t + std::max(search.plunge, search.zone) / (fa.speed(t) - fb.speed(t)).norm();
    if (!(search.from < search.to)) return never;
  }
}

/// Finds the first impacts of two bodies and keeps the earliest of each body in `impacts.found`. In
/// the first round all bodies fly freely. In the second round stopped bodies stay at their
/// position, in the way of the others.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
class impact_finder : shape_pairs<Scenario, ShapeA, ShapeB, Partner> {
  using base = shape_pairs<Scenario, ShapeA, ShapeB, Partner>;
  using base::paired, base::imaged;
  using base::s_, base::a_, base::b_, base::first_a_, base::first_b_;
  using typename base::body_pair, typename base::state_type;
  using typename base::store_b;

 public:
  explicit impact_finder(state_type& s) : base(s) {}

  void operator()(std::size_t i, std::size_t j, real, real) {
    this->order(i, j);
    body_pair x;
    x.i = i, x.j = j;
    if (!this->find(x)) return;
    if (!x.own_a && !(paired && x.own_b)) return;
    if (!x.moves_a && !x.moves_b) return;
    const std::size_t body_b = this->body_b(x);
    auto fa = flight_through(s_, a_, i, this->position_a(x));
    auto fb = flight_through(s_, b_, j, this->position_b(x));
    const real zone = contact_zone(a_.shape[i], b_.shape[j]);
    real way = way_of(s_, a_, i);
    if constexpr (paired) way += way_of(s_, b_, j);
    if constexpr (!paired) way += way_of_driven<ShapeB>(s_, a_, i, j);
    if (!(way > slow_way(s_, zone))) return;

    impact_search search = search_for(s_, a_.shape[i], b_.shape[j]);
    real& time_a = s_.impacts.found[first_a_ + i];
    if (s_.impacts.second_round) {
      // The body that stops first is in the way of the other from then on.
      const real until_a = std::min(s_.impacts.time[first_a_ + i], s_.dt);
      const real until_b = paired ? std::min(s_.impacts.time[first_b_ + body_b], s_.dt) : s_.dt;
      search.from = std::min(until_a, until_b);
      search.to = std::max(until_a, until_b);
      if (!(search.from < search.to)) return;
      if (until_a < until_b)
        fa = fa.stopped(until_a);
      else if (paired)
        fb = fb.stopped(until_b);
      else
        return;  // global bodies stand there anyway
    }
    const real t = meeting_of<ShapeB, paired>(s_, a_, i, fa, b_, j, fb, search);
    if (t == never) return;
    if (x.moves_a) time_a = std::min(time_a, t);
    if constexpr (paired) {
      real& time_b = s_.impacts.found[first_b_ + body_b];
      if (x.moves_b) time_b = std::min(time_b, t);
    }
  }

 private:
};

/// Copies the value of each body owned here to its images.
template <class Scenario>
void give_to_images(population<Scenario>& s, plain_vector<real>& values) {
  std::size_t k = 0;
  s.each_finite_shape([&](const auto& b) {
    const auto& copies = s.copies.of[k++];
    for (std::size_t c = 0; c < copies.size(); ++c)
      if (copies[c].own != image_copy::not_own)
        values[b.first + b.movable.locals + c] = values[b.first + copies[c].own];
  });
}

/// Throws runtime_error if a body flies over domains that the connections do not cover.
template <class Scenario>
void require_covered_flights(const world_state<Scenario>& s) {
  if constexpr (requires { s.own.covered(); }) {
    const real covered = s.own.covered();
    s.each_finite_shape([&](const auto& b) {
      for (std::size_t i = 0; i < b.movable.locals; ++i)
        if (const real way = way_of(s, b.movable, i); way > covered)
          fail<std::runtime_error>(
              "body {} at {} moves by {} in step {}, further than the {} that the connections of "
              "rank {} cover, so that what it meets there would be lost: decompose with "
              "a reach of {}, or take a smaller time step",
              b.movable.id[i], text(b.movable.position[i]), text(way, 4), s.steps, text(covered, 4),
              s.link->rank(), text(way, 4));
    });
  }
}

/// The time by which a body whose flight this is rotates with its present velocity, from its
/// present orientation to that at time t.
template <class Scenario, class Flight>
[[nodiscard]] real turning_time(const world_state<Scenario>& s, const Flight& flight, real t) {
  if constexpr (world_state<Scenario>::midpoint)
    return flight.turning_until(t) / kept_by_damping(s);
  else
    return (void)s, (void)flight, t;
}

/// Moves bodies with an impact in this step, and the shadow copies of such bodies, to the time of
/// their first impact; s.impacts.time holds the times, `never` for all others.
template <class Scenario, class EachClosePair>
void follow_flights(world_state<Scenario>& s, EachClosePair&& each_neighbour_pair) {
  require_covered_flights(s);
  std::size_t bodies = 0;
  s.each_finite_shape([&](auto& b) { bodies += b.movable.size(); });
  auto& impacts = s.impacts;
  impacts.time.assign(bodies, never);
  impacts.found.assign(bodies, never);
  for (const bool second : {false, true}) {
    impacts.second_round = second;
    const bool some =
        std::any_of(impacts.time.begin(), impacts.time.end(), [](real t) { return t != never; });
    if (!second || some) each_neighbour_pair();
    impacts.time = impacts.found;
    if constexpr (!world_state<Scenario>::link_type::alone)
      shared_velocities<Scenario>(s).share_values(impacts.time);
    if constexpr (world_state<Scenario>::periodic) give_to_images(s, impacts.time);
    impacts.found = impacts.time;
  }
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    using store_type = std::remove_reference_t<decltype(store)>;
    for (std::size_t i = 0; i < store.size(); ++i) {
      const real t = impacts.time[b.first + i];
      if (t == never || store.inverse_mass[i] == 0) continue;
      const pose from = store.pose(i);
      const vec3 w = store.angular_velocity[i];
      const auto flight = flight_through(s, store, i, store.position[i]);
      const real turning = turning_time(s, flight, t);
      if constexpr (world_state<Scenario>::periodic)
        if (image_copy* copy = copy_of<typename store_type::shape_type>(s, i)) {
          // As its owner computes it.
          store.position[i] = flight_through(s, store, i, copy->home).place(t);
          put_image(s, store.position[i], *copy);
        }
      if (!world_state<Scenario>::periodic || i < store.locals) store.position[i] = flight.place(t);
      if constexpr (store_type::tensor)
        store.angular_velocity[i] = rotate_either_way(
            store.orientation_of[i], store.angular_velocity[i], store.shape[i].inertia(), turning);
      else if constexpr (store_type::oriented)
        store.orientation_of[i] =
            turned<real>(store.orientation_of[i], turning * store.angular_velocity[i]);
      if constexpr (monitored<Scenario, energy_ledger>)
        if (i < store.locals) book_flight(s, store, i, from, w);
      (void)from, (void)w, (void)turning;
    }
  });
}

/// The reach of a body for its contacts, when its flight is known. (A body that rotates in place or
/// flies slowly was not followed; one with an impact moves by half its inner radius at most.)
template <class Scenario, class Store>
[[nodiscard]] real reach_after_flight(const world_state<Scenario>& s, const Store& store,
                                      std::size_t i, std::size_t body) {
  const real radius = store.shape[i].bounding_radius(), slack = contact_slack * radius;
  const real furthest = s.impacts.time[body] == never
                            ? slack
                            : std::max(slack, real(0.5) * inner_radius(store.shape[i]));
  return radius + slack + std::min(way_of(s, store, i), furthest);
}

/// With the midpoint: the mean velocity of a body from its impact at time t to the end of the step,
/// where its velocity is v.
template <class Scenario, class Store>
[[nodiscard]] vec3 rest_velocity(const world_state<Scenario>& s, const Store& store, std::size_t i,
                                 const vec3& v, real t) {
  return v - (kept_by_damping(s) * real(0.5) * (s.dt - t)) * acceleration_of(s, store, i);
}

/// After an impact: the flight of a body after it, as if it had been on it since the start of the
/// step. `at` is its present position. Also that of other bodies.
template <class Scenario, class Store>
[[nodiscard]] auto rest_of_flight(const world_state<Scenario>& s, const Store& store, std::size_t i,
                                  std::size_t body, const vec3& at) {
  free_flight<Store::tensor> f;
  f.position = at;
  f.orientation = store.pose(i).orientation;
  if (store.inverse_mass[i] == 0) return f;
  const real t = s.impacts.time[body];
  const real since = t == never ? time_of_poses(s) : t;
  f.velocity = solved_velocity(s, store, i, body);
  constexpr bool midpoint = world_state<Scenario>::midpoint;
  constexpr bool divided = uses_substeps<typename Scenario::solver>;
  if constexpr (midpoint) {
    const real kept = kept_by_damping(s);
    const vec3 end = kept * f.velocity;
    if (t != never) {
      f.velocity = rest_velocity(s, store, i, end, t);
    } else {
      f.velocity = store.velocity[i] / kept;
      f.acceleration = (end - f.velocity) / s.dt;
    }
  } else if constexpr (divided)
    f.velocity += s.solver.drift[body].v;  // the mean of its substeps
  else if (t != never)
    f.velocity += (real(0.5) * t) * acceleration_of(s, store, i);
  if constexpr (Store::tensor) {
    f.spin = solved_spin(s, store, i, body);
    if constexpr (midpoint) f.spin *= kept_by_damping(s);
    if constexpr (divided) f.spin += s.solver.drift[body].w;
    f.inertia = store.shape[i].inertia();
  }
  f.position -= since * f.velocity, f.turned = since;
  return f;
}

/// A body that is stopped for the last `lost` units of a step has a velocity with all of the step's
/// acceleration, but has not moved in that time: it gets the speed that matches its path, otherwise
/// under gravity its energy would grow with every stop. The direction is that of the contact
/// solution. `path` is its velocity on the path.
template <class Scenario, class Store>
void end_flight(world_state<Scenario>& s, Store& store, std::size_t i, real lost,
                const vec3& path) {
  const vec3 v = store.velocity[i];
  const real square = v.squaredNorm();
  if (!(lost > 0) || square == 0) return;
  const real gained = 2 * lost * acceleration_of(s, store, i).dot(path);
  store.velocity[i] = std::sqrt(std::max<real>(0, 1 - gained / square)) * v;
  if constexpr (monitored<Scenario, energy_ledger>)
    s.monitors.energy.running.scheme +=
        (store.velocity[i].squaredNorm() - square) / (2 * store.inverse_mass[i]);
  if constexpr (monitored<Scenario, momentum_balance>)
    s.monitors.momentum.gravity += (store.velocity[i] - v) / store.inverse_mass[i];
}

/// Ends the rest of the step of a body with an impact at its next impact.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
class flight_stopper : shape_pairs<Scenario, ShapeA, ShapeB, Partner> {
  using base = shape_pairs<Scenario, ShapeA, ShapeB, Partner>;
  using base::paired, base::imaged;
  using base::s_, base::a_, base::b_, base::first_a_, base::first_b_;
  using typename base::body_pair, typename base::state_type;
  using typename base::store_b;

 public:
  explicit flight_stopper(state_type& s) : base(s) {}

  void operator()(std::size_t i, std::size_t j, real, real) {
    this->order(i, j);
    body_pair x;
    x.i = i, x.j = j;
    if (!this->find(x)) return;
    const std::size_t a = first_a_ + i, b = first_b_ + this->body_b(x);
    const auto& time = s_.impacts.time;
    if constexpr (!paired && state_type::drives)
      if (s_.impacts.second_round) return carry(i, j);
    if (state_type::drives && s_.impacts.second_round) return;
    const bool stops_a = x.own_a && time[a] != never;
    const bool stops_b = paired && x.own_b && time[b] != never;
    if (!stops_a && !stops_b) return;
    // From the later of the two impacts on; a body without impact is still at its start.
    impact_search search = search_for(s_, a_.shape[i], b_.shape[j]);
    const auto fa = rest_of_flight(s_, a_, i, a, this->position_a(x));
    free_flight<store_b::tensor> fb;
    if constexpr (paired)
      fb = rest_of_flight(s_, b_, j, b, this->position_b(x));
    else
      fb = flight_of(s_, b_, j), fb.position = this->position_b(x);
    const real from_a = time[a] == never ? 0 : time[a];
    const real from_b = !paired || time[b] == never ? 0 : time[b];
    search.from = std::max(from_a, from_b);
    const real t = meeting_of<ShapeB, paired>(s_, a_, i, fa, b_, j, fb, search);
    if (t == never) return;
    if (stops_a) s_.impacts.found[a] = std::min(s_.impacts.found[a], t);
    if (stops_b) s_.impacts.found[b] = std::min(s_.impacts.found[b], t);
  }

 private:
  /// Whether the driven body reaches the stopped body i, and when.
  void carry(std::size_t i, std::size_t j) {
    const std::size_t a = first_a_ + i;
    const driven_body* one = going_body<ShapeB>(s_, j);
    if (one == nullptr || i >= a_.locals || s_.impacts.time[a] == never) return;
    impact_search search = search_for(s_, a_.shape[i], b_.shape[j]);
    search.from = s_.impacts.found[a];
    search.plunge = 0;
    if (!(search.from < s_.dt)) return;
    const auto fa = rest_of_flight(s_, a_, i, a, a_.position[i]);
    const real t = meeting_of<ShapeB, paired>(s_, a_, i, fa.stopped(search.from), b_, j,
                                              flight_of(s_, b_, j), search);
    auto& carrier = s_.impacts.carriers[a];
    const vec3 start = one->state.at.point - time_of_poses(s_) * one->next.v;
    if (t < carrier.from) carrier = {t, start, one->next.v, one->next.w};
  }
};

/// The pose at the end of the step of a body that was stopped at `position` and is carried along.
template <class Carried>
[[nodiscard]] vec3 carried_to(const Carried& by, const vec3& position, real dt) {
  const real turn = (dt - by.from) * by.w.norm();
  const vec3 arm = position - by.origin - by.from * by.v;
  return by.origin + dt * by.v + (turn > 0 ? rotated(rotation(by.w, turn), arm) : arm);
}

/// After the response: the end of the flight of bodies with an impact, in s.impacts.found.
template <class Scenario, class EachClosePair>
void limit_flights(world_state<Scenario>& s, EachClosePair&& each_neighbour_pair) {
  auto& impacts = s.impacts;
  // Other solvers end their sweeps with velocities of copies from before the last sweep, which is
  // near enough if results may depend on the ranks.
  if constexpr (world_state<Scenario>::may_use_colours && !world_state<Scenario>::link_type::alone)
    if (s.by_colours()) shared_velocities<Scenario>(s).share_velocities();
  impacts.found.assign(impacts.time.size(), s.dt);
  if (std::all_of(impacts.time.begin(), impacts.time.end(), [](real t) { return t == never; }))
    return;
  s.each_finite_shape([&](auto& b) {
    auto& store = b.movable;
    for (std::size_t i = 0; i < store.locals; ++i) {
      const real t = impacts.time[b.first + i];
      if (t == never) continue;
      const auto f = rest_of_flight(s, store, i, b.first + i, store.position[i]);
      real speed = f.velocity.norm();
      if constexpr (std::remove_reference_t<decltype(store)>::tensor)
        speed += store.shape[i].bounding_radius() * f.spin.norm();
      const real furthest = real(0.5) * inner_radius(store.shape[i]);
      if (speed * (s.dt - t) > furthest) impacts.found[b.first + i] = t + furthest / speed;
    }
  });
  impacts.second_round = false;
  each_neighbour_pair();
  if constexpr (world_state<Scenario>::drives) {
    impacts.carriers.assign(impacts.time.size(), {});
    impacts.second_round = true;
    each_neighbour_pair();
  }
}

}  // namespace talus::detail
