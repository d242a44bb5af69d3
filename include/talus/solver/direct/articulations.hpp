#pragma once
// Joints that are solved together, exactly, with all other impulses held.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "talus/constraint/joint_line.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/disjoint_sets.hpp"
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

 private:
  static std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const auto& body(std::int32_t i) const { return s_.bodies[index(i)]; }
  State& s_;
};

/// Joints that movable bodies connect.
class articulation {
 public:
  void add(const joint_view& x) { joints_.push_back(x); }

  /// Numbers the bodies, and finds the structure of the system. `number` holds -1 for all bodies,
  /// before and after.
  template <class Bodies>
  void arrange(const Bodies& all, plain_vector<std::int32_t>& number) {
    bodies_.clear(), inverse_mass_.clear(), inverse_inertia_.clear(), first_.clear();
    plain_vector<articulated_system::tie> ties;
    std::size_t rows = 0;
    const auto local = [&](std::int32_t i) {
      if (all.inverse_mass(i) == 0) return std::int32_t{-1};
      std::int32_t& k = number[at(i)];
      if (k < 0) {
        k = static_cast<std::int32_t>(bodies_.size());
        bodies_.push_back(i);
        inverse_mass_.push_back(all.inverse_mass(i));
        inverse_inertia_.push_back(all.inverse_inertia(i));
      }
      return k;
    };
    for (const joint_view& x : joints_) {
      const std::int32_t a = local(x.a), b = local(x.b);
      ties.push_back({a, b, x.rows});
      first_.push_back(rows);
      rows += at(x.rows);
    }
    for (const std::int32_t i : bodies_) number[at(i)] = -1;
    ties_ = std::move(ties);
    system_.arrange(static_cast<std::int32_t>(bodies_.size()), {ties_.data(), ties_.size()});
    held_.assign(rows, bound::none);
    factorized_ = false;
  }

  /// Changes the impulses of the joints, and the motions of the bodies, so that all rows hold.
  template <class Bodies>
  void solve(Bodies& all) {
    bool bounded = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (!x.bounded()) return;
      bounded = true;
      if (factorized_) return;
      if (r <= x.least) held_[first_[j] + k] = bound::least;
      if (r >= x.most) held_[first_[j] + k] = bound::most;
    });
    if (bounded) move_to_bounds(all);
    constexpr int all_at_once = 8, rounds = 40;
    for (int round = 0; round < rounds; ++round) {
      refine(all);
      if (!bounded || !change_bounds(all, round >= all_at_once)) break;
      move_to_bounds(all);
      factorized_ = false;
    }
    if (bounded) move_within_bounds(all);
  }

 private:
  enum class bound : char { none, least, most };
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  /// Calls f(joint, row, line, impulse) for the rows in use.
  template <class F>
  void each_row(F&& f) {
    for (std::size_t j = 0; j < joints_.size(); ++j)
      for (std::size_t k = 0; k < at(joints_[j].rows); ++k)
        if (const joint_line& x = joints_[j].lines[k]; x.use != line_use::off)
          f(j, k, x, joints_[j].impulse[k]);
  }
  template <class Bodies>
  [[nodiscard]] static real rate(const joint_line& x, const Bodies& all, const joint_view& of) {
    const body_motion a = all.motion(of.a), b = all.motion(of.b);
    return x.force.dot(a.v - b.v) + (x.moment_a.dot(a.w) - x.moment_b.dot(b.w));
  }
  template <class Bodies>
  void push(Bodies& all, std::size_t j, const joint_line& x, real d) {
    const auto move = [&](std::int32_t body, std::int32_t k, real p, const vec3& moment) {
      if (k >= 0)
        all.add(body,
                {(p * inverse_mass_[at(k)]) * x.force, p * (inverse_inertia_[at(k)] * moment)});
    };
    move(joints_[j].a, ties_[j].a, d, x.moment_a);
    move(joints_[j].b, ties_[j].b, -d, x.moment_b);
  }

  void factorize() {
    system_.clear();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      system_.set_body(static_cast<std::int32_t>(i), 1 / inverse_mass_[i],
                       inverse_inertia_[i].inverse());
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real&) {
      if (held_[first_[j] + k] != bound::none) return;
      const vec3 &p = x.force, &a = x.moment_a, &b = x.moment_b;
      real scale = x.compliance;
      const auto add = [&](std::int32_t i, const vec3& moment) {
        if (i >= 0)
          scale +=
              inverse_mass_[at(i)] * p.squaredNorm() + moment.dot(inverse_inertia_[at(i)] * moment);
      };
      add(ties_[j].a, a), add(ties_[j].b, b);
      if (scale > 0)
        system_.set_row(static_cast<std::int32_t>(j), static_cast<std::int32_t>(k),
                        {p[0], p[1], p[2], a[0], a[1], a[2]},
                        {-p[0], -p[1], -p[2], -b[0], -b[1], -b[2]}, x.compliance, scale);
    });
    system_.factorize();
    factorized_ = true;
  }

  /// Solves the rows that are at no bound, and repeats that with what is left of them.
  template <class Bodies>
  void refine(Bodies& all) {
    constexpr int most = 8;
    real last = unbounded;
    for (int k = 0; k < most; ++k) {
      real left = 0, scale = 0;
      rest_.assign(system_.size(), 0);
      each_row([&](std::size_t j, std::size_t i, const joint_line& x, real& r) {
        if (held_[first_[j] + i] != bound::none) return;
        const body_motion a = all.motion(joints_[j].a), b = all.motion(joints_[j].b);
        const real u = x.force.dot(a.v - b.v) + (x.moment_a.dot(a.w) - x.moment_b.dot(b.w));
        const real e = x.target - u - x.compliance * r;
        const std::size_t row = system_.of_joint(static_cast<std::int32_t>(j)) + i;
        rest_[row] = e;
        left = std::max(left, std::abs(e));
        scale = std::max({scale, std::abs(x.target),
                          x.force.norm() * (a.v.norm() + b.v.norm()) +
                              x.moment_a.norm() * a.w.norm() + x.moment_b.norm() * b.w.norm()});
        if (factorized_) scale = std::max(scale, system_.left_of(row) * std::abs(r));
      });
      scale_ = scale;
      if (!(left > real(4e-16) * scale) || (k > 1 && !(left < real(0.5) * last))) return;
      last = left;
      if (!factorized_) factorize();
      if (k == 0)  // impulses of rows that depend on others would grow by round-off
        each_row([&](std::size_t j, std::size_t i, const joint_line&, real& r) {
          if (held_[first_[j] + i] != bound::none) return;
          const std::size_t row = system_.of_joint(static_cast<std::int32_t>(j)) + i;
          rest_[row] -= system_.added(row) * r;
        });
      system_.solve(rest_);
      each_row([&](std::size_t j, std::size_t i, const joint_line& x, real& r) {
        if (held_[first_[j] + i] != bound::none) return;
        const real d = -rest_[system_.of_joint(static_cast<std::int32_t>(j)) + i];
        r += d;
        push(all, j, x, d);
      });
    }
  }
  /// Rows beyond a bound stay on it from now on, and rows that a bound keeps from holding while
  /// that is not needed leave it; one of them, or all. Returns whether there were any.
  template <class Bodies>
  bool change_bounds(const Bodies& all, bool one) {
    bool changed = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (!x.bounded() || (one && changed)) return;
      bound& held = held_[first_[j] + k];
      const bound before = held;
      if (held == bound::none) {
        if (r < x.least) held = bound::least;
        if (r > x.most) held = bound::most;
      } else {
        const real excess = rate(x, all, joints_[j]) + x.compliance * r - x.target;
        const real small = 1e-12 * scale_;
        if (held == bound::least ? excess < -small : excess > small) held = bound::none;
      }
      changed = changed || held != before;
    });
    return changed;
  }
  template <class Bodies>
  void move_to_bounds(Bodies& all) {
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      const bound held = held_[first_[j] + k];
      if (held == bound::none) return;
      const real to = held == bound::least ? x.least : x.most;
      if (to == r) return;
      push(all, j, x, to - r);
      r = to;
    });
  }
  /// If the search for the right bounds has not ended.
  template <class Bodies>
  void move_within_bounds(Bodies& all) {
    each_row([&](std::size_t j, std::size_t, const joint_line& x, real& r) {
      const real to = std::clamp(r, x.least, x.most);
      if (to == r) return;
      push(all, j, x, to - r);
      r = to;
    });
  }

  plain_vector<joint_view> joints_;
  plain_vector<std::size_t> first_;  ///< row of each joint
  plain_vector<std::int32_t> bodies_;
  plain_vector<real> inverse_mass_;
  plain_vector<mat3> inverse_inertia_;
  plain_vector<articulated_system::tie> ties_;
  plain_vector<bound> held_;  ///< by rows
  articulated_system system_;
  plain_vector<real> rest_;
  real scale_ = 0;  ///< of velocities
  bool factorized_ = false;
};

/// All articulations of a rank.
class articulations {
 public:
  template <class Bodies>
  void gather(std::span<const joint_view> joints, const Bodies& all) {
    all_.clear();
    if (joints.empty()) return;
    plain_vector<std::int32_t> number(all.size(), -1);
    sets_.reset(all.size());
    const auto moves = [&](std::int32_t i) { return all.inverse_mass(i) != 0; };
    for (const joint_view& x : joints)
      if (moves(x.a) && moves(x.b)) sets_.join(x.a, x.b);
    plain_vector<std::int32_t> roots;
    for (const joint_view& x : joints) {
      if (!moves(x.a) && !moves(x.b)) continue;
      const auto root = static_cast<std::int32_t>(sets_.root(moves(x.a) ? x.a : x.b));
      std::int32_t& k = number[static_cast<std::size_t>(root)];
      if (k < 0) {
        k = static_cast<std::int32_t>(all_.size());
        all_.emplace_back();
        roots.push_back(root);
      }
      all_[static_cast<std::size_t>(k)].add(x);
    }
    for (const std::int32_t root : roots) number[static_cast<std::size_t>(root)] = -1;
    for (articulation& one : all_) one.arrange(all, number);
  }
  template <class Bodies>
  void solve(Bodies&& all) {
    for (articulation& one : all_) one.solve(all);
  }
  [[nodiscard]] bool empty() const { return all_.empty(); }

 private:
  std::vector<articulation> all_;
  disjoint_sets sets_;
};

}  // namespace talus::detail
