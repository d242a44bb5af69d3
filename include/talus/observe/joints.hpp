#pragma once
// What joints bear, and how well they hold.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <tuple>
#include <type_traits>

#include "talus/constraint/line_writer.hpp"
#include "talus/state/joints.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// One joint, alike on all ranks: see joint_handle.
struct joint_reading {
  bool exists = false;   ///< it was neither released nor broken
  vec3 force{0, 0, 0};   ///< on its first body in the last step, mean value
  vec3 torque{0, 0, 0};  ///< on its first body about the point of the joint, mean value
  double angle = 0;      ///< radians; 0 if this kind has none
  double travel = 0;     ///< length; 0 if this kind has none
  joint_load motor;      ///< on its angle or travel; 0 without one, likewise:
  joint_load spring;     ///< with its damper
  joint_load friction;   ///< of its angle or travel
  joint_loads second;    ///< of the second coordinate, of kinds with two: the travel of a
                         ///< cylindrical_joint, the second angle of a universal_joint
};

/// Collective: what the ranks that hold the joint know of it. All is 0 if no rank holds it.
template <class Scenario, class Kind>
[[nodiscard]] joint_reading measure_joint(world<Scenario>& w,
                                          const joint_handle<Scenario, Kind>& joint) {
  w.require_all_ranks("measure_joint");
  joint_reading x;
  const auto fields = std::to_array<double*>({&x.force[0],
                                              &x.force[1],
                                              &x.force[2],
                                              &x.torque[0],
                                              &x.torque[1],
                                              &x.torque[2],
                                              &x.angle,
                                              &x.travel,
                                              &x.motor.load,
                                              &x.motor.power,
                                              &x.spring.load,
                                              &x.spring.power,
                                              &x.friction.load,
                                              &x.friction.power,
                                              &x.second.motor.load,
                                              &x.second.motor.power,
                                              &x.second.spring.load,
                                              &x.second.spring.power,
                                              &x.second.friction.load,
                                              &x.second.friction.power});
  std::array<double, std::tuple_size_v<decltype(fields)> + 1> sums{};  // the last counts ranks
  if (joint.known()) {
    x.force = joint.force(), x.torque = joint.torque();
    if constexpr (requires { Kind::has_angle; }) x.angle = joint.angle();
    if constexpr (requires { Kind::has_travel; }) x.travel = joint.travel();
    if constexpr (detail::has_axes<Kind>) {
      const joint_loads first = joint.loads();
      x.motor = first.motor, x.spring = first.spring, x.friction = first.friction;
      x.second = joint.loads(1);
    }
    for (std::size_t k = 0; k < fields.size(); ++k) sums[k] = *fields[k];
    sums.back() = 1;
  }
  w.link().reduce(reduction::sum, sums);
  x.exists = sums.back() > 0;
  for (std::size_t k = 0; k < fields.size(); ++k)  // one value, of one or two ranks
    *fields[k] = x.exists ? sums[k] / sums.back() : 0;
  return x;
}

/// By how much joints are violated.
struct joint_errors {
  std::uint64_t joints = 0;  ///< number of all joints
  double gap = 0;            ///< largest distance of what a joint holds together, length
  double angle = 0;          ///< largest error of a direction or an angle, radians
};

/// Collective: the errors of the positions of all joints, of all kinds, after the last step.
/// Limits count where they are passed.
template <class Scenario>
[[nodiscard]] joint_errors measure_joints(world<Scenario>& w) {
  static_assert(detail::world_state<Scenario>::has_joints,
                "measure_joints needs joints: name their kinds in joints<...> of this scenario");
  w.require_all_ranks("measure_joints");
  auto& s = detail::state_of(w);
  std::array<double, 2> most{};
  std::uint64_t count = 0;
  detail::plain_vector<detail::joint_end> ends = detail::find_joint_ends(s);
  const detail::jointed_ids& ids = s.joints.ids();
  const auto locate = [&](system_id id, const vec3& position, const quat& orientation) {
    if (const std::size_t k = ids.find(id); k != detail::jointed_ids::unknown)
      ends[k].known = true, ends[k].position = position, ends[k].orientation = orientation;
  };
  locate(detail::id_of_world, {0, 0, 0}, {1, 0, 0, 0});
  s.each_shape([&](const auto& b) {
    for (std::size_t j = 0; j < b.global.size(); ++j)
      locate(b.global.id[j], b.global.position[j], b.global.pose(j).orientation);
  });
  s.joints.each_kind([&](const auto& of_kind) {
    using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
    for (const auto& r : of_kind.records) {
      const detail::joint_end &a = ends[ids.find(r.key.a)], &b = ends[ids.find(r.key.b)];
      const bool movable_a = a.moves || a.asleep, movable_b = b.moves || b.asleep;
      const bool own_a = a.own && movable_a, own_b = b.own && movable_b;
      if (!(own_a || own_b) || !a.known || !b.known) continue;
      count += own_a || !movable_a;
      const pose at_a{a.position, a.orientation};
      const detail::joint_geometry g = detail::geometry_of(
          r.anchors.frames, at_a,
          {detail::seen_from(s, r.anchors.frames, at_a, b.position), b.orientation});
      std::array<detail::joint_line, static_cast<std::size_t>(kind::rows)> lines{};
      detail::joint_coordinates coordinates = r.coordinates;
      const detail::jointed_body still{};
      detail::line_writer writer(lines, coordinates, g, still, still, {.dt = 1});
      kind::write(r.anchors, writer);
      std::array<double, 2> squares{};
      for (const detail::joint_line& x : lines) {
        if (x.use != detail::line_use::holds && !(x.use == detail::line_use::limits && x.error < 0))
          continue;
        squares[x.force == vec3(0, 0, 0) ? 1 : 0] += x.error * x.error;
      }
      for (std::size_t k = 0; k < 2; ++k) most[k] = detail::larger(most[k], std::sqrt(squares[k]));
    }
  });
  w.link().reduce(reduction::max, most);
  w.link().reduce(reduction::sum, std::span(&count, 1));
  return {count, most[0], most[1]};
}

}  // namespace talus
