#pragma once
// The step of jointed bodies by an energy-momentum method, for integrators of second order.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/core/plain_vector.hpp"
#include "talus/motion/mean_rotation.hpp"
#include "talus/state/state.hpp"
#include "talus/step/moved_joints.hpp"

namespace talus::detail {

/// A larger error is no solution: of a step that is too long for its loads.
inline constexpr real largest_error = 1e-10;
/// From a step with this error the bodies are moved to where the joints hold.
inline constexpr real useful_error = 1e-6;

/// The step of a jointed body.
struct body_step {
  vec3 inertia{0, 0, 0};  ///< principal moments
  real inverse_mass = 0;
  vec3 first_momentum{0, 0, 0};                         ///< angular, at the start
  vec3 velocity{0, 0, 0}, momentum{0, 0, 0};            ///< at the end
  vec3 free_velocity{0, 0, 0}, free_momentum{0, 0, 0};  ///< without the joints
  vec3 free_position{0, 0, 0};
  vec3 turn{0, 0, 0};  ///< by the position correction

  void push(const joint_line& x, const vec3& moment, real p) {
    velocity += (p * inverse_mass) * x.force, momentum += p * moment;
  }
};

/// Computes the step of the jointed bodies again, with rows in the mean of the configurations
/// before and after it (an energy-momentum method, as of Simo and Gonzalez 1993): conditions hold
/// after the step, to round-off, and their impulses do no work. Unknowns are the impulses of the
/// conditions and the momenta of the bodies (Newton). Returns the error; `steps` are those of the
/// bodies.
template <class Scenario>
[[nodiscard]] real conserve_with_joints(const world_state<Scenario>& s,
                                        moved_joints<Scenario>& joints,
                                        plain_vector<body_step>& steps) {
  const plain_vector<joint_end>& before = joints.before;
  const real dt = s.dt, kept = kept_by_damping(s);
  steps.assign(joints.ends.size(), body_step{});
  const auto push = [&](const moved_joint& j, const joint_line& x, real p) {
    if (joints.bodies.moves(j.a)) steps[static_cast<std::size_t>(j.a)].push(x, x.moment_a, p);
    if (joints.bodies.moves(j.b)) steps[static_cast<std::size_t>(j.b)].push(x, x.moment_b, -p);
  };
  const auto push_all = [&](auto&& lines, real part) {
    for (const moved_joint& j : joints.all)
      for (int k = 0; k < j.solved.rows; ++k)
        push(j, lines(j)[static_cast<std::size_t>(k)], part * j.solved.impulse[k]);
  };
  const auto solved_lines = [](const moved_joint& j) { return j.solved.lines; };
  const auto written_lines = [&](const moved_joint& j) { return joints.lines(j); };
  const auto each_moving = [&](auto&& f) {
    for (std::size_t k = 0; k < steps.size(); ++k)
      if (joints.bodies.moves(static_cast<std::int32_t>(k)))
        f(steps[k], joints.ends[k], before[k], static_cast<std::int32_t>(k));
  };

  for (std::size_t k = 0; k < steps.size(); ++k) {
    const moved_body& body = joints.of[k];
    if (!body.end.moves) continue;
    body_step& x = steps[k];
    x.inverse_mass = body.end.inverse_mass;
    x.inertia = body.inertia;
    const auto momentum = [&](const joint_end& e) {
      return e.orientation * vec3(x.inertia.cwiseProduct(e.orientation.conjugate() * e.spin));
    };
    x.first_momentum = momentum(before[k]), x.momentum = momentum(body.end);
    x.velocity = body.end.velocity;
    x.free_position = body.end.position - (dt / 2) * body.end.velocity;
    x.turn = body.turn;
  }
  plain_vector<body_step> assumed = steps;
  push_all(solved_lines, -kept);
  each_moving([&](body_step& x, joint_end&, const joint_end&, std::int32_t k) {
    x.free_velocity = x.velocity, x.free_momentum = x.momentum;
    x.velocity = assumed[static_cast<std::size_t>(k)].velocity;
    x.momentum = assumed[static_cast<std::size_t>(k)].momentum;
  });
  plain_vector<real> found;
  for (const moved_joint& j : joints.all) {
    // How the moments of the impulses change with the rotation of their arms.
    const joint_geometry g = joints.geometry(j, joints.ends);
    vec3 p{0, 0, 0};
    for (int k = 0; k < j.solved.rows; ++k) p += j.solved.impulse[k] * j.solved.lines[k].force;
    const auto stiffen = [&](std::int32_t body, const vec3& arm, const vec3& impulse) {
      mat3 by = diagonal_matrix<real>(arm.dot(impulse));
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          by(i, k) -= real(0.5) * (arm[i] * impulse[k] + impulse[i] * arm[k]);
      joints.bodies.stiffen(body, (dt / 4) * by);
    };
    stiffen(j.a, g.arm_a, p), stiffen(j.b, g.arm_b, -p);
    for (int k = 0; k < j.solved.rows; ++k) found.push_back(j.solved.impulse[k]);
  }

  const auto search = [&] {
    return joints.iterate(
        1,
        [&] {
          each_moving([&](body_step& x, joint_end& end, const joint_end& start, std::int32_t) {
            end.velocity = x.velocity, end.position = x.free_position + (dt / 2) * x.velocity;
            end.orientation =
                turned<real>(rotated_by_mean(start.orientation, x.inertia, x.first_momentum,
                                             x.momentum, dt, end.spin),
                             x.turn);
          });
          real worst = 0;
          plain_vector<real> errors;
          for (const moved_joint& j : joints.all) {
            const joint_geometry g = joints.geometry(j, joints.ends);
            joints.write(j, g);
            worst = larger(worst, joints.error(j));
            for (const joint_line& x : joints.lines(j)) errors.push_back(x.error);
            joints.write(j, mean_of(joints.geometry(j, before), g));
          }
          // The momenta by the impulses, with the rows as they are now, beside those assumed.
          assumed = steps;
          each_moving([](body_step& x, joint_end&, const joint_end&, std::int32_t) {
            x.velocity = x.free_velocity, x.momentum = x.free_momentum;
          });
          push_all(written_lines, kept);
          each_moving([&](body_step& x, joint_end&, const joint_end&, std::int32_t k) {
            const body_step& before = assumed[static_cast<std::size_t>(k)];
            const body_motion rest{
                x.velocity - before.velocity,
                joints.bodies.inverse_inertia(k) * (x.momentum - before.momentum)};
            joints.bodies.add(k, rest);
            x.velocity = before.velocity, x.momentum = before.momentum;
            worst = larger(worst, (dt / 2) * rest.w.norm());
          });
          for (const moved_joint& j : joints.all)
            for (std::size_t k = 0; k < joints.lines(j).size(); ++k) {
              joint_line& x = joints.lines(j)[k];
              if (x.use != line_use::holds) x.use = line_use::off;
              x.target = real(-2) / dt * errors[j.first + k];
            }
          return worst;
        },
        [&] {
          each_moving([&](body_step& x, joint_end&, const joint_end&, std::int32_t k) {
            const body_motion& d = joints.bodies.motion(k);
            x.velocity += d.v;
            x.momentum += joints.bodies.own_inverse_inertia(k).inverse() * d.w;
          });
          for (const moved_joint& j : joints.all)
            for (int k = 0; k < j.solved.rows; ++k)
              j.solved.impulse[k] += joints.impulses(j)[static_cast<std::size_t>(k)] / kept;
        });
  };
  real error = search();
  if (!(error < largest_error)) {
    // Where rows nearly depend on each other, as in a stretched linkage, the impulses that were
    // solved in the middle of the step are far off: start from those of the last step.
    for (const moved_joint& j : joints.all)
      for (int k = 0; k < j.solved.rows; ++k) j.solved.impulse[k] = j.solved.earlier[k];
    each_moving([](body_step& x, joint_end&, const joint_end&, std::int32_t) {
      x.velocity = x.free_velocity, x.momentum = x.free_momentum;
    });
    push_all(solved_lines, kept);
    error = search();
  }
  if (!(error < largest_error))
    for (const moved_joint& j : joints.all)
      for (int k = 0; k < j.solved.rows; ++k)
        j.solved.impulse[k] = found[j.first + static_cast<std::size_t>(k)];
  return error;
}

/// Where no such solution is found, as in a singular position, bodies are moved to where the joints
/// hold. Their velocities then are changed so that they satisfy the joints there, and scaled to the
/// energy that the work of all other impulses leaves. (They are not scaled where nothing holds the
/// island, since that would change its momentum, and where what holds it moves.)
template <class Scenario>
void fit_velocities(const world_state<Scenario>& s, moved_joints<Scenario>& joints,
                    const plain_vector<body_step>& steps) {
  (void)joints.iterate(
      1,
      [&] {
        real worst = 0;
        for (const moved_joint& j : joints.all) {
          joints.write(j, joints.geometry(j, joints.ends));
          const joint_end &a = joints.ends[static_cast<std::size_t>(j.a)],
                          &b = joints.ends[static_cast<std::size_t>(j.b)];
          for (joint_line& x : joints.lines(j)) {
            const real rate = x.force.dot(a.velocity - b.velocity) + x.moment_a.dot(a.spin) -
                              x.moment_b.dot(b.spin);
            if (x.use != line_use::holds) x.use = line_use::off;
            x.target = -rate;
            if (x.use != line_use::off) worst = larger(worst, std::abs(rate) * s.dt);
          }
        }
        return worst;
      },
      [&] {
        for (std::size_t k = 0; k < joints.ends.size(); ++k) {
          const body_motion& d = joints.bodies.motion(static_cast<std::int32_t>(k));
          joints.ends[k].velocity += d.v, joints.ends[k].spin += d.w;
        }
      });
  plain_vector<body_step> given_to = steps;  // by gravity, contacts, motors, springs and limits
  for (body_step& x : given_to) x.velocity = x.free_velocity, x.momentum = x.free_momentum;
  for (const moved_joint& j : joints.all)
    for (int k = 0; k < j.solved.rows; ++k)
      if (const joint_line& x = j.solved.lines[k]; x.use != line_use::holds) {
        const real p = j.solved.impulse[k];
        if (joints.bodies.moves(j.a))
          given_to[static_cast<std::size_t>(j.a)].push(x, x.moment_a, p);
        if (joints.bodies.moves(j.b))
          given_to[static_cast<std::size_t>(j.b)].push(x, x.moment_b, -p);
      }
  bool held = false, carried = false;
  real had = 0, has = 0, given = 0, part = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const joint_end &from = joints.before[k], &to = joints.ends[k];
    if (!to.moves) {
      held = true;
      carried = carried || to.velocity != vec3(0, 0, 0) || to.spin != vec3(0, 0, 0);
      continue;
    }
    const body_step& x = given_to[k];
    const real mass = 1 / x.inverse_mass;
    const auto energy = [&](const joint_end& e) {
      const vec3 own = e.orientation.conjugate() * e.spin;
      return real(0.5) *
             (mass * e.velocity.squaredNorm() + x.inertia.dot(vec3(own.cwiseProduct(own))));
    };
    had += energy(from), has += energy(to);
    given += mass * s.gravity.dot(to.position - from.position);
    const vec3 push = mass * (x.velocity - from.velocity - s.dt * s.gravity),
               turn = x.momentum - x.first_momentum;
    given += real(0.5) * (push.dot(from.velocity) + turn.dot(from.spin));
    part += real(0.5) * (push.dot(to.velocity) + turn.dot(to.spin));
  }
  // has f² = had + given + part f
  const real root = part * part + 4 * has * (had + given);
  if (!held || carried || s.damping != 1 || !(has > 0) || !(root > 0)) return;
  const real factor = (part + std::sqrt(root)) / (2 * has);
  constexpr real most = 1.1;
  if (!(factor < most && factor > 1 / most)) return;
  for (joint_end& e : joints.ends)
    if (e.moves) e.velocity *= factor, e.spin *= factor;
}

}  // namespace talus::detail
