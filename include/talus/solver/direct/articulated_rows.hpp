#pragma once
// The rows of joints that movable bodies connect, and these bodies.
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/constraint/joint_line.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulated_system.hpp"

namespace talus::detail {

/// The bodies of a solver's state as articulations see them.
template <class State>
class solver_bodies {
 public:
  explicit solver_bodies(State& s) : s_(s) {}
  [[nodiscard]] std::size_t size() const { return s_.bodies.size(); }
  [[nodiscard]] real inverse_mass(std::int32_t i) const { return real(body(i).inverse_mass); }
  [[nodiscard]] mat3 inverse_inertia(std::int32_t i) const {
    if (s_.has_tensor(index(i))) return s_.tensor(index(i));
    return diagonal_matrix<real>(real(body(i).inverse_inertia));
  }
  [[nodiscard]] body_motion motion(std::int32_t i) const { return {v_of(body(i)), w_of(body(i))}; }
  void add(std::int32_t i, const body_motion& d) {
    using number = typename State::number;
    auto& x = s_.bodies[index(i)];
    x.v += in_scalar<number>(d.v), x.w += in_scalar<number>(d.w);
  }
  void set(std::int32_t i, const body_motion& to) {
    using number = typename State::number;
    auto& x = s_.bodies[index(i)];
    x.v = in_scalar<number>(to.v), x.w = in_scalar<number>(to.w);
  }

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const auto& body(std::int32_t i) const { return s_.bodies[index(i)]; }
  State& s_;
};

/// Joints that movable bodies connect. The members have numbers of their own.
struct articulated_rows {
  plain_vector<joint_view> joints;
  plain_vector<std::size_t> first;  ///< row of each joint, of `rows`
  std::size_t rows = 0;
  plain_vector<std::int32_t> bodies;
  plain_vector<real> inverse_mass;
  plain_vector<mat3> inverse_inertia;
  plain_vector<articulated_system::tie> ties;

  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  /// Numbers the bodies. `number` holds -1 for all bodies, before and after.
  template <class Bodies>
  void arrange(const Bodies& all, plain_vector<std::int32_t>& number) {
    bodies.clear(), inverse_mass.clear(), inverse_inertia.clear(), first.clear(), ties.clear();
    rows = 0;
    const auto local = [&](std::int32_t i) {
      if (i < 0 || all.inverse_mass(i) == 0) return std::int32_t{-1};
      std::int32_t& k = number[at(i)];
      if (k < 0) {
        k = static_cast<std::int32_t>(bodies.size());
        bodies.push_back(i);
        inverse_mass.push_back(all.inverse_mass(i));
        inverse_inertia.push_back(all.inverse_inertia(i));
      }
      return k;
    };
    for (const joint_view& x : joints) {
      const std::int32_t a = local(x.a), b = local(x.b);
      ties.push_back({a, b, x.rows});
      first.push_back(rows);
      rows += at(x.rows);
    }
    for (const std::int32_t i : bodies) number[at(i)] = -1;
  }
  /// Calls f(joint, row, line, impulse) for the rows in use.
  template <class F>
  void each_row(F&& f) {
    for (std::size_t j = 0; j < joints.size(); ++j)
      for (std::size_t k = 0; k < at(joints[j].rows); ++k)
        if (const joint_line& x = joints[j].lines[k]; x.use != line_use::off)
          f(j, k, x, joints[j].impulse[k]);
  }
  template <class Bodies>
  [[nodiscard]] static real rate(const joint_line& x, const Bodies& all, const joint_view& of) {
    const body_motion a = all.motion(of.a), b = all.motion(of.b);
    return x.force.dot(a.v - b.v) + (x.moment_a.dot(a.w) - x.moment_b.dot(b.w));
  }
  template <class Bodies>
  void push(Bodies& all, std::size_t j, const joint_line& x, real d) const {
    const auto move = [&](std::int32_t body, std::int32_t k, real p, const vec3& moment) {
      if (k >= 0)
        all.add(body, {(p * inverse_mass[at(k)]) * x.force, p * (inverse_inertia[at(k)] * moment)});
    };
    move(joints[j].a, ties[j].a, d, x.moment_a);
    move(joints[j].b, ties[j].b, -d, x.moment_b);
  }

  /// The velocity of a row for a unit impulse.
  [[nodiscard]] real mobility(std::size_t j, const joint_line& x) const {
    real sum = x.compliance;
    const auto add = [&](std::int32_t i, const vec3& moment) {
      if (i >= 0)
        sum += inverse_mass[at(i)] * x.force.squaredNorm() +
               moment.dot(inverse_inertia[at(i)] * moment);
    };
    add(ties[j].a, x.moment_a), add(ties[j].b, x.moment_b);
    return sum;
  }
  static void set_row(articulated_system& to, std::size_t j, std::size_t k, const joint_line& x,
                      real compliance, real scale) {
    const vec3 &p = x.force, &a = x.moment_a, &b = x.moment_b;
    to.set_row(static_cast<std::int32_t>(j), static_cast<std::int32_t>(k),
               {p[0], p[1], p[2], a[0], a[1], a[2]}, {-p[0], -p[1], -p[2], -b[0], -b[1], -b[2]},
               compliance, scale);
  }
  /// Sets the bodies, with a multiple of their masses.
  void set_bodies(articulated_system& to, real part) const {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      to.set_body(static_cast<std::int32_t>(i), part / inverse_mass[i],
                  part * inverse_inertia[i].inverse());
  }
};

}  // namespace talus::detail
