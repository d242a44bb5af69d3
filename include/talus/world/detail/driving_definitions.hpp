#pragma once
// Motion of global bodies. Member functions of world.
#include <array>
#include <cstddef>
#include <span>

#include "talus/parallel/reduction.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The record of a global body that is to be driven, from its present position.
template <class Scenario>
template <class Shape>
detail::driven_body& world<Scenario>::driven_body_of(handle<Shape> h, const char* what) {
  sections_.require_all_ranks(what, rank());
  const auto& store = state_.template of<Shape>().global;
  const auto at = std::find(store.id.begin(), store.id.end(), h.id);
  if (at == store.id.end())
    detail::fail<std::invalid_argument>(
        "{} takes a global body, and rank {} has no global {} {}: add it in world.global(...)",
        what, rank(), Shape::name, h.id);
  auto& all = state_.driving.all;
  auto one = std::find_if(all.begin(), all.end(), [&](const auto& x) { return x->id == h.id; });
  if (one == all.end()) {
    all.push_back(std::make_unique<detail::driven_body>());
    one = all.end() - 1;
    (*one)->id = h.id;
    if constexpr (keeps) keeper_.add("driven body " + detail::text(h.id), (*one)->state);
  }
  const auto i = static_cast<std::size_t>(at - store.id.begin());
  detail::driven_body& body = **one;
  body.state = {};
  body.state.origin = body.state.at.point = store.position[i];
  body.state.orientation = store.pose(i).orientation;
  if constexpr (!Shape::finite) {
    body.state.normal = store.shape[i].unit_normal();
    body.state.offset = store.shape[i].offset;
  }
  body.is_servo = false;
  body.plan = nullptr;
  return body;
}

template <class Scenario>
template <class Shape, class Motion>
void world<Scenario>::drive(handle<Shape> h, Motion motion) {
  detail::motion_of_body<Motion>();
  if constexpr (detail::require_feature<Scenario, driven>() && detail::is_motion<Motion>) {
    detail::driven_body& body = driven_body_of(h, "drive");
    using value = decltype(motion(real{}));
    if constexpr (std::is_same_v<value, rigid_displacement>) {
      if (detail::counts_from_call<Motion>) body.state.since = state_.time;
      body.plan = [motion](const detail::driven_state& s, real time, real dt) {
        const real t = time - s.since;
        return detail::step_to(s, motion(t), motion(t + detail::instant * dt), motion(t + dt), dt);
      };
      const auto& store = state_.template of<Shape>().global;
      const auto at = std::find(store.id.begin(), store.id.end(), h.id);
      detail::require_no_jump(store.shape[static_cast<std::size_t>(at - store.id.begin())], body,
                              motion(state_.time - body.state.since), state_.time, [this] {
                                std::array<real, 2> sums{};  // radii and number of bodies
                                state_.each_finite_shape([&](const auto& b) {
                                  for (std::size_t i = 0; i < b.movable.locals; ++i)
                                    if (!b.movable.fixed(i))
                                      sums[0] += b.movable.shape[i].bounding_radius(), ++sums[1];
                                });
                                link().reduce(reduction::sum, std::span<real>(sums));
                                return sums[1] > 0 ? sums[0] / sums[1] : 0;
                              });
    } else {
      body.plan = [motion](const detail::driven_state& s, real t, real dt) {
        return detail::step_at(s, motion(t + dt / 2), dt);
      };
    }
  }
}

template <class Scenario>
template <class Shape>
void world<Scenario>::hold_force(handle<Shape> h, const servo& how) {
  if constexpr (detail::require_feature<Scenario, driven>()) {
    if (how.force.given() == how.pressure.given())
      detail::fail<std::invalid_argument>(
          "world.hold_force takes a .force or a .pressure, and was given {}",
          how.force.given() ? "both" : "neither");
    if (how.pressure.given() && Shape::finite)
      detail::fail<std::invalid_argument>(
          "only a plane holds a pressure, as its area follows from the other planes, and this is a "
          "{}: give .force instead",
          Shape::name);
    if (how.force.given() && !how.force.changes())
      detail::require_positive(how.force(0), "the force of a servo");
    if (how.pressure.given() && !how.pressure.changes())
      detail::require_positive(how.pressure(0), "the pressure of a servo");
    detail::require_positive(how.max_speed, "the greatest speed of a servo");
    detail::require_finite("the axis of a servo", how.axis);
    detail::driven_state before;
    vec3 pressed(0, 0, 0);
    for (const auto& one : state_.driving.all)
      if (one->id == h.id && one->is_servo) before = one->state, pressed = one->holds.axis;
    detail::driven_body& body = driven_body_of(h, "hold_force");
    vec3 axis = unit(how.axis);
    if constexpr (!Shape::finite)
      if (axis == vec3(0, 0, 0)) axis = body.state.normal;
    if (axis == vec3(0, 0, 0))
      detail::fail<std::invalid_argument>(
          "a servo moves the {} {} along an axis: give the direction in which it presses",
          Shape::name, h.id);
    body.holds = how;
    body.holds.axis = axis;
    body.is_servo = true;
    body.state.speed = how.max_speed;
    if (before.mass > 0 && pressed == axis) {  // it goes on pressing, with another force
      body.state.speed = std::clamp(before.speed, -how.max_speed, how.max_speed);
      body.state.mass = before.mass, body.state.force = before.force;
    }
    body.plan = [axis](const detail::driven_state& s, real, real dt) {
      return detail::step_of_servo(s, axis, dt);
    };
  }
}

template <class Scenario>
template <class Shape>
void world<Scenario>::halt(handle<Shape> h) {
  if constexpr (detail::require_feature<Scenario, driven>()) (void)driven_body_of(h, "halt");
}

}  // namespace talus
