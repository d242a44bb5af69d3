#pragma once
// The rows of a joint in a solver, for all kinds of joints. joint_in_list makes a constraint of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/body/jointed_body.hpp"
#include "talus/constraint/joint_geometry.hpp"
#include "talus/constraint/joint_line.hpp"
#include "talus/constraint/line_writer.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/guarded_cholesky.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

/// A body moved and rotated by its velocities during dt.
[[nodiscard]] inline pose carried(const jointed_body& x, real dt) {
  const vec3 half = (real(0.5) * dt) * x.spin;
  return {x.at.position + dt * x.velocity,
          (quat(1, half[0], half[1], half[2]).normalized() * x.at.orientation).normalized()};
}

template <class Kind, class State>
struct joint_rows {
  using state = State;
  using number = typename State::number;
  using anchors = typename Kind::anchors;
  static constexpr bool paired = true;
  static constexpr int rows = Kind::rows;
  using change = row_values<rows>;

  std::array<joint_line, static_cast<std::size_t>(rows)> lines;
  change r;        ///< impulses
  change earlier;  ///< those of the last step
  change correction_impulse;
  change correction_rate;  ///< of the rows, which removes the position errors
  change split;            ///< velocities that correct what isotropic bodies do not correct
  change before;           ///< velocities of the rows at the start of the step
  small_system<rows> system, correction;
  vec3 arm_a{0, 0, 0};  ///< from the centre of mass of a to its point
  std::int32_t a = 0, b = 0;

  /// The rows for a step. The correction removes all of the position error, and in advance that
  /// which the curvature of the motion in a step causes: velocities at its start do not see it.
  void place(const anchors& x, const jointed_body& on_a, const jointed_body& on_b,
             const joint_moment& when, joint_coordinates& coordinates) {
    const auto write = [&](const pose& at_a, const pose& at_b, joint_coordinates& to) {
      lines.fill({});
      const joint_geometry g = geometry_of(x.frames, at_a, at_b);
      arm_a = g.arm_a;
      line_writer writer(lines, to, g, on_a, on_b, when);
      Kind::write(x, writer);
    };
    joint_coordinates later = coordinates;
    write(carried(on_a, when.dt), carried(on_b, when.dt), later);
    for (int k = 0; k < rows; ++k) correction_rate[k] = lines[index(k)].error;
    write(on_a.at, on_b.at, coordinates);
    for (int k = 0; k < rows; ++k) {
      const joint_line& line = lines[index(k)];
      const real u = line.force.dot(on_a.velocity - on_b.velocity) + line.moment_a.dot(on_a.spin) -
                     line.moment_b.dot(on_b.spin);
      before[k] = u;
      const bool corrects = line.use == line_use::holds && !when.reflects;
      correction_rate[k] = corrects ? u - correction_rate[k] / when.dt : 0;
      split[k] = corrects ? real(-0.2) / when.dt * line.error : 0;
    }
  }
  /// The force laws for a part of the step: the same forces act for a shorter time.
  void take_part(real part) {
    for (joint_line& x : lines) x.compliance /= part, x.least *= part, x.most *= part;
  }
  [[nodiscard]] joint_view view() {
    return {a, b, rows, lines.data(), r.at.data(), earlier.at.data(), before.at.data()};
  }

  void prepare(const state& s, real split_a, real split_b) {
    system = correction = {};
    for (int i = 0; i < rows; ++i) {
      const joint_line& x = lines[index(i)];
      if (x.use == line_use::off) continue;
      const body_motion by_a = response(s, a, x.force, x.moment_a, split_a),
                        by_b = response(s, b, x.force, x.moment_b, split_b);
      const body_motion turn_a = has_tensor(s, a) ? by_a : body_motion{by_a.v, {0, 0, 0}},
                        turn_b = has_tensor(s, b) ? by_b : body_motion{by_b.v, {0, 0, 0}};
      for (int j = 0; j <= i; ++j) {
        const joint_line& y = lines[index(j)];
        if (y.use == line_use::off) continue;
        system.a[index(i)][index(j)] = rate(y, by_a, by_b);
        correction.a[index(i)][index(j)] = rate(y, turn_a, turn_b);
      }
      system.a[index(i)][index(i)] += x.compliance;
      if (correction.a[index(i)][index(i)] > 0 || x.use != line_use::holds) split[i] = 0;
    }
  }
  change relax(const state& s) {
    const change u = velocities(s);
    for (int k = 0; k < rows; ++k) {
      const joint_line& x = lines[index(k)];
      system.b[index(k)] = x.target + split[k] - u[k] - x.compliance * r[k];
    }
    const change d = within_bounds();
    r = r + d;
    return d;
  }
  void apply(state& s, const change& d) const { apply_to_a(s, d), apply_to_b(s, d); }
  void apply_to_a(state& s, const change& d) const {
    const wrench x = wrench_on_a(d);
    push(s, a, x.impulse, x.moment);
  }
  void apply_to_b(state& s, const change& d) const {
    const wrench x = wrench_on_b(d);
    push(s, b, x.impulse, x.moment);
  }

  [[nodiscard]] const change& impulse_in_frame() const { return r; }
  [[nodiscard]] change since(const change& before) const { return r - before; }
  void set(const change& next) { r = next; }
  [[nodiscard]] wrench on_a() const { return wrench_on_a(r); }
  [[nodiscard]] wrench on_b() const { return wrench_on_b(r); }
  /// The impulses of motors, springs and friction: they may do work.
  [[nodiscard]] change driven() const {
    change d;
    for (int k = 0; k < rows; ++k)
      if (drives(lines[index(k)].use)) d[k] = r[k];
    return d;
  }
  /// The work of the drives on both bodies.
  [[nodiscard]] real driven_work(const state& s) const {
    return real(0.5) * driven().dot(before + velocities(s));
  }
  /// The impulses of the force laws of each coordinate, and the mean rate of the coordinate.
  [[nodiscard]] axis_drives drives_of_axes(const state& s) const {
    axis_drives all{};
    const change after = velocities(s);
    for (int k = 0; k < rows; ++k) {
      const joint_line& x = lines[index(k)];
      if (!drives(x.use)) continue;
      axis_drive& to = all[x.axis];
      (x.use == line_use::motor    ? to.motor
       : x.use == line_use::spring ? to.spring
                                   : to.friction) = r[k];
      to.rate = real(0.5) * (before[k] + after[k]);
    }
    return all;
  }
  [[nodiscard]] wrench wrench_on_a(const change& d) const {
    wrench x;
    for (int k = 0; k < rows; ++k)
      x.impulse += d[k] * lines[index(k)].force, x.moment += d[k] * lines[index(k)].moment_a;
    return x;
  }
  /// Calls f(line, work) for the rows in use, with the works of their impulses on body a or b,
  /// which moves with v and rotates with w.
  template <class F>
  void each_work(bool on_a, const vec3& v, const vec3& w, F&& f) const {
    for (int k = 0; k < rows; ++k) {
      const joint_line& x = lines[index(k)];
      if (x.use == line_use::off) continue;
      const real rate = x.force.dot(v) + (on_a ? x.moment_a : x.moment_b).dot(w);
      f(x, on_a ? r[k] * rate : -r[k] * rate);
    }
  }
  [[nodiscard]] wrench wrench_on_b(const change& d) const {
    wrench x;
    for (int k = 0; k < rows; ++k)
      x.impulse -= d[k] * lines[index(k)].force, x.moment -= d[k] * lines[index(k)].moment_b;
    return x;
  }

  /// The violation of the rows, as velocities: 0 where an impulse is at a bound that it needs.
  [[nodiscard]] change relative_velocity(const state& s) const {
    change u = velocities(s);
    for (int k = 0; k < rows; ++k) {
      const joint_line& x = lines[index(k)];
      u[k] += x.compliance * r[k] - x.target;
      const real w = x.bounded() ? system.a[index(k)][index(k)] : real(0);
      if (w > 0) u[k] = w * (r[k] - std::clamp(r[k] - u[k] / w, x.least, x.most));
    }
    return u;
  }
  [[nodiscard]] real delassus_trace(const state& s) const {
    real sum = 0;
    for (const joint_line& x : lines)
      if (x.use != line_use::off)
        sum += rate(x, response(s, a, x.force, x.moment_a, 1),
                    response(s, b, x.force, x.moment_b, 1)) +
               x.compliance;
    return sum;
  }
  [[nodiscard]] real speed_of(const change& d) const { return product(system, d); }

  change relax_correction(const state& s) {
    const body_motion of_a{in_scalar<real>(s.shift[index(a)].v), turn(s, a)},
        of_b{in_scalar<real>(s.shift[index(b)].v), turn(s, b)};
    for (int k = 0; k < rows; ++k) {
      const joint_line& x = lines[index(k)];
      correction.b[index(k)] = correction_rate[k] - x.force.dot(of_a.v - of_b.v) -
                               x.moment_a.dot(of_a.w) + x.moment_b.dot(of_b.w);
    }
    change d;
    d.at = correction.solved([&](std::size_t k) { return lines[k].use == line_use::holds; });
    correction_impulse = correction_impulse + d;
    return d;
  }
  void correct_a(state& s, const change& d) const {
    const wrench x = wrench_on_a(d);
    correct(s, a, x);
  }
  void correct_b(state& s, const change& d) const {
    const wrench x = wrench_on_b(d);
    correct(s, b, x);
  }

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
  static bool has_tensor(const state& s, std::int32_t i) { return s.has_tensor(index(i)); }

  [[nodiscard]] change velocities(const state& s) const {
    const auto &x = s.bodies[index(a)], &y = s.bodies[index(b)];
    const vec3 v = v_of(x) - v_of(y), wa = w_of(x), wb = w_of(y);
    change u;
    for (int k = 0; k < rows; ++k) {
      const joint_line& l = lines[index(k)];
      u[k] = l.force.dot(v) + (l.moment_a.dot(wa) - l.moment_b.dot(wb));
    }
    return u;
  }
  /// The rate of a row, where body a moves with one and b with the opposite of the other.
  static real rate(const joint_line& y, const body_motion& of_a, const body_motion& of_b) {
    return y.force.dot(of_a.v + of_b.v) + (y.moment_a.dot(of_a.w) + y.moment_b.dot(of_b.w));
  }
  static body_motion response(const state& s, std::int32_t i, const vec3& p, const vec3& moment,
                              real parts) {
    const auto& x = s.bodies[index(i)];
    const vec3 w = has_tensor(s, i) ? vec3(s.tensor(index(i)) * moment)
                                    : vec3(real(x.inverse_inertia) * moment);
    return {(parts * real(x.inverse_mass)) * p, parts * w};
  }
  static void push(state& s, std::int32_t i, const vec3& p, const vec3& moment) {
    const body_motion d = response(s, i, p, moment, 1);
    auto& x = s.bodies[index(i)];
    x.v += in_scalar<number>(d.v);
    x.w += in_scalar<number>(d.w);
  }
  static vec3 turn(const state& s, std::int32_t i) {
    return has_tensor(s, i) ? s.turn[index(i) - s.first_tensor].w : vec3(0, 0, 0);
  }
  // The correction moves isotropic bodies without turning them.
  static void correct(state& s, std::int32_t i, const wrench& x) {
    s.shift[index(i)].v +=
        in_scalar<number>(vec3(real(s.bodies[index(i)].inverse_mass) * x.impulse));
    if (has_tensor(s, i)) s.turn[index(i) - s.first_tensor].w += s.tensor(index(i)) * x.moment;
  }

  /// The change of the impulses that solves the system, within their bounds: rows that would leave
  /// a bound stay on it, and leave it if that is right.
  [[nodiscard]] change within_bounds() {
    enum class at : char { neither, least, most };
    std::array<at, static_cast<std::size_t>(rows)> held{};
    change d;
    const auto rest = system;
    for (std::size_t k = 0; k < held.size(); ++k) {  // out of reach by itself
      const real w = rest.a[k][k];
      if (lines[k].use == line_use::off || !lines[k].bounded() || !(w > 0)) continue;
      const real alone = r.at[k] + rest.b[k] / w;
      if (alone < lines[k].least) held[k] = at::least;
      if (alone > lines[k].most) held[k] = at::most;
    }
    constexpr int tries = 4 * rows;
    for (int round = 0; round < tries; ++round) {
      small_system<rows> now = rest;
      for (std::size_t k = 0; k < held.size(); ++k) {
        if (held[k] == at::neither) continue;
        d.at[k] = (held[k] == at::least ? lines[k].least : lines[k].most) - r.at[k];
        for (std::size_t i = 0; i < held.size(); ++i) now.b[i] -= entry(rest, i, k) * d.at[k];
      }
      const auto x = now.solved(
          [&](std::size_t k) { return lines[k].use != line_use::off && held[k] == at::neither; });
      for (std::size_t k = 0; k < held.size(); ++k)
        if (held[k] == at::neither) d.at[k] = x[k];
      bool changed = false;
      for (std::size_t k = 0; k < held.size(); ++k) {
        if (lines[k].use == line_use::off || !lines[k].bounded()) continue;
        const real next = r.at[k] + d.at[k];
        if (held[k] == at::neither) {
          if (next < lines[k].least) held[k] = at::least, changed = true;
          if (next > lines[k].most) held[k] = at::most, changed = true;
          continue;
        }
        real excess = -rest.b[k];
        for (std::size_t i = 0; i < held.size(); ++i) excess += entry(rest, k, i) * d.at[i];
        const real small = 1e-12 * std::abs(rest.b[k]);
        if (held[k] == at::least ? excess < -small : excess > small)
          held[k] = at::neither, changed = true;
        if (changed && round > rows) break;  // one at a time, against cycles
      }
      if (!changed) return d;
    }
    for (std::size_t k = 0; k < held.size(); ++k)
      if (lines[k].bounded())
        d.at[k] = std::clamp(r.at[k] + d.at[k], lines[k].least, lines[k].most) - r.at[k];
    return d;
  }
  static real entry(const small_system<rows>& m, std::size_t i, std::size_t j) {
    return i < j ? m.a[j][i] : m.a[i][j];
  }
  /// The length of the product of the matrix and a vector.
  static real product(const small_system<rows>& m, const change& d) {
    real square = 0;
    for (std::size_t i = 0; i < d.at.size(); ++i) {
      real sum = 0;
      for (std::size_t j = 0; j < d.at.size(); ++j) sum += entry(m, i, j) * d.at[j];
      square += sum * sum;
    }
    return std::sqrt(square);
  }
};

}  // namespace talus::detail
