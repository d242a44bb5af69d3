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
    held_.assign(rows, bound::none), start_.assign(rows, 0), residuals_.assign(rows, 0);
    factorized_ = false;
  }
  /// The rows are others from now on, and the factorization is an approximation.
  void renew() { stale_ = true; }

  /// Changes the impulses of the joints, and the motions of the bodies, so that all rows hold.
  template <class Bodies>
  void solve(Bodies& all) {
    bool bounded = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      start_[first_[j] + k] = r;
      if (!x.bounded()) return;
      bounded = true;
      if (factorized_) return;
      const real w = mobility(j, x);
      const real alone =
          w > 0 ? r + (x.target - rate(x, all, joints_[j]) - x.compliance * r) / w : r;
      if (alone <= x.least) held_[first_[j] + k] = bound::least;
      if (alone >= x.most) held_[first_[j] + k] = bound::most;
    });
    if (bounded) note_motions(all), move_to_bounds(all);
    constexpr int all_at_once = 8, rounds = 40, adding = 32;
    for (int round = 0; round < rounds; ++round) {
      refine(all);
      if (!bounded) break;
      const bool more = round < adding ? change_bounds(all, round >= all_at_once) || meet_bound()
                                       : hold_beyond_bounds();
      if (!more) break;
      start_again(all);
    }
    if (bounded) move_within_bounds(all);
  }

  /// Of all impulses of dependent rows that give the bodies the same momenta, takes those of least
  /// norm, where a row counts by its mobility.
  void share_loads() {
    if (!factorized_ || !any_depends()) return;
    constexpr real softness = 1e-8, enough = 1e-15, useful = 1e-12;
    constexpr int most = 20;
    // Rows as springs with their mobilities as compliances, which bear the momenta; bodies as weak
    // springs keep the matrix regular.
    articulated_system springs = system_;
    springs.clear();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      springs.set_body(static_cast<std::int32_t>(i), softness / inverse_mass_[i],
                       softness * inverse_inertia_[i].inverse());
    plain_vector<real> loads(springs.size(), 0), left, x(springs.size(), 0);
    each_shared([&](std::size_t j, std::size_t k, const joint_line& line, real& r, real w) {
      set_row(springs, j, k, line, w, w);
      add_momenta(springs, j, line, r, loads);
    });
    springs.factorize();
    const auto size_of = [&](const plain_vector<real>& all, std::size_t from) {
      real sum = 0;
      for (std::size_t i = 0; i < bodies_.size(); ++i)
        for (std::size_t k = from; k < from + 3; ++k)
          sum = std::max(sum, std::abs(all[springs.of_body(static_cast<std::int32_t>(i)) + k]));
      return sum;
    };
    const real push = size_of(loads, 0), turn = size_of(loads, 3);
    real last = unbounded;
    for (int pass = 0; pass < most; ++pass) {
      left = loads;
      each_shared([&](std::size_t j, std::size_t k, const joint_line& line, real&, real w) {
        const std::size_t row = springs.of_joint(static_cast<std::int32_t>(j)) + k;
        add_momenta(springs, j, line, -x[row], left);
        left[row] = w * x[row] - of_bodies(springs, j, line, x);
      });
      const real worst = std::max(push > 0 ? size_of(left, 0) / push : real(0),
                                  turn > 0 ? size_of(left, 3) / turn : real(0));
      if (worst <= enough || (pass > 1 && !(worst < real(0.5) * last))) {
        last = std::min(last, worst);
        break;
      }
      last = worst;
      springs.solve(left);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += left[i];
    }
    if (last <= useful)
      each_shared([&](std::size_t j, std::size_t k, const joint_line&, real& r, real) {
        r = x[springs.of_joint(static_cast<std::int32_t>(j)) + k];
      });
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

  /// The velocity of a row for a unit impulse.
  [[nodiscard]] real mobility(std::size_t j, const joint_line& x) const {
    real sum = x.compliance;
    const auto add = [&](std::int32_t i, const vec3& moment) {
      if (i >= 0)
        sum += inverse_mass_[at(i)] * x.force.squaredNorm() +
               moment.dot(inverse_inertia_[at(i)] * moment);
    };
    add(ties_[j].a, x.moment_a), add(ties_[j].b, x.moment_b);
    return sum;
  }
  static void set_row(articulated_system& to, std::size_t j, std::size_t k, const joint_line& x,
                      real compliance, real scale) {
    const vec3 &p = x.force, &a = x.moment_a, &b = x.moment_b;
    to.set_row(static_cast<std::int32_t>(j), static_cast<std::int32_t>(k),
               {p[0], p[1], p[2], a[0], a[1], a[2]}, {-p[0], -p[1], -p[2], -b[0], -b[1], -b[2]},
               compliance, scale);
  }
  void factorize() {
    system_.clear();
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      system_.set_body(static_cast<std::int32_t>(i), 1 / inverse_mass_[i],
                       inverse_inertia_[i].inverse());
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real&) {
      if (held_[first_[j] + k] != bound::none) return;
      if (const real scale = mobility(j, x); scale > 0)
        set_row(system_, j, k, x, x.compliance, scale);
    });
    system_.factorize();
    factorized_ = true, stale_ = false;
  }
  [[nodiscard]] bool depends(std::size_t j, std::size_t k) const {
    return factorized_ && system_.depends(row_of(j, k));
  }
  [[nodiscard]] std::size_t row_of(std::size_t j, std::size_t k) const {
    return system_.of_joint(static_cast<std::int32_t>(j)) + k;
  }

  // Loads that rows share.
  [[nodiscard]] bool any_depends() {
    bool any = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real&) {
      any = any || (x.use == line_use::holds && mobility(j, x) > 0 && depends(j, k));
    });
    return any;
  }
  /// Calls f(joint, row, line, impulse, mobility) for the rows that only the motion determines.
  template <class F>
  void each_shared(F&& f) {
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (x.use != line_use::holds) return;
      if (const real w = mobility(j, x); w > 0) f(j, k, x, r, w);
    });
  }
  /// Adds the momenta that an impulse gives to the bodies.
  void add_momenta(const articulated_system& of, std::size_t j, const joint_line& x, real r,
                   plain_vector<real>& to) const {
    const auto add = [&](std::int32_t i, real p, const vec3& moment) {
      if (i < 0) return;
      real* at_body = to.data() + of.of_body(i);
      for (int k = 0; k < 3; ++k) at_body[k] += p * x.force[k], at_body[3 + k] += p * moment[k];
    };
    add(ties_[j].a, r, x.moment_a), add(ties_[j].b, -r, x.moment_b);
  }
  /// The velocity of a row by those of its bodies.
  [[nodiscard]] real of_bodies(const articulated_system& of, std::size_t j, const joint_line& x,
                               const plain_vector<real>& from) const {
    real sum = 0;
    const auto add = [&](std::int32_t i, real sign, const vec3& moment) {
      if (i < 0) return;
      const real* at_body = from.data() + of.of_body(i);
      for (int k = 0; k < 3; ++k)
        sum += sign * (x.force[k] * at_body[k] + moment[k] * at_body[3 + k]);
    };
    add(ties_[j].a, 1, x.moment_a), add(ties_[j].b, -1, x.moment_b);
    return sum;
  }

  /// Solves the rows that are at no bound, and repeats that with what is left of them. The
  /// residuals of rows that depend on others follow from these.
  template <class Bodies>
  void refine(Bodies& all) {
    constexpr int most = 8;
    real last = unbounded;
    for (int k = 0; k < most; ++k) {
      real left = 0, scale = 0;
      rest_.assign(system_.size(), 0), contradiction_ = 0;
      each_row([&](std::size_t j, std::size_t i, const joint_line& x, real& r) {
        if (held_[first_[j] + i] != bound::none) return;
        const body_motion a = all.motion(joints_[j].a), b = all.motion(joints_[j].b);
        const real u = x.force.dot(a.v - b.v) + (x.moment_a.dot(a.w) - x.moment_b.dot(b.w));
        const real e = x.target - u - x.compliance * r;
        rest_[row_of(j, i)] = residuals_[first_[j] + i] = e;
        real& worst = depends(j, i) ? contradiction_ : left;
        worst = std::max(worst, std::abs(e));
        scale = std::max({scale, std::abs(x.target),
                          x.force.norm() * (a.v.norm() + b.v.norm()) +
                              x.moment_a.norm() * a.w.norm() + x.moment_b.norm() * b.w.norm()});
        if (factorized_) scale = std::max(scale, system_.left_of(row_of(j, i)) * std::abs(r));
      });
      scale_ = scale;
      const bool slow = k > 0 && !(left < real(0.5) * last);
      if (!(left > real(4e-16) * scale) || (k > 1 && slow && !stale_)) return;
      last = left;
      if (!factorized_ || (slow && stale_)) factorize();
      if (k == 0)  // impulses of rows that depend on others would grow by round-off
        each_row([&](std::size_t j, std::size_t i, const joint_line&, real& r) {
          if (held_[first_[j] + i] == bound::none)
            rest_[row_of(j, i)] -= system_.added(row_of(j, i)) * r;
        });
      system_.solve(rest_);
      each_row([&](std::size_t j, std::size_t i, const joint_line& x, real& r) {
        if (held_[first_[j] + i] != bound::none) return;
        const real d = -rest_[row_of(j, i)];
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
  /// Rows beyond a bound stay on it, and no row leaves one: the end of a search that has cycled.
  bool hold_beyond_bounds() {
    bool changed = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      bound& held = held_[first_[j] + k];
      if (held != bound::none || (r >= x.least && r <= x.most)) return;
      held = r < x.least ? bound::least : bound::most;
      changed = true;
    });
    return changed;
  }
  /// Where rows contradict each other, impulses that do not move the bodies grow until the first of
  /// them meets a bound: it stays there. Returns whether there is one.
  bool meet_bound() {
    const real small = 1e-9 * scale_;
    if (!factorized_ || !(contradiction_ > small)) return false;
    rest_.assign(system_.size(), 0);
    each_row([&](std::size_t j, std::size_t k, const joint_line&, real&) {
      if (depends(j, k) && held_[first_[j] + k] == bound::none)
        rest_[row_of(j, k)] = residuals_[first_[j] + k];
    });
    system_.solve(rest_);
    real most = 0;
    each_row([&](std::size_t j, std::size_t k, const joint_line&, real&) {
      most = std::max(most, std::abs(rest_[row_of(j, k)]));
    });
    bound* first = nullptr;
    bound to = bound::none;
    real soonest = unbounded;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      bound& held = held_[first_[j] + k];
      const real d = -rest_[row_of(j, k)];
      if (held != bound::none || !x.bounded() || !(std::abs(d) > 1e-9 * most)) return;
      const real when = ((d > 0 ? x.most : x.least) - r) / d;
      if (when < soonest) soonest = when, first = &held, to = d > 0 ? bound::most : bound::least;
    });
    if (first == nullptr) return false;
    *first = to;
    return true;
  }

  // All impulses are added to the motions before, so that those of a trial leave no round-off.
  template <class Bodies>
  void note_motions(const Bodies& all) {
    before_.clear();
    for (const std::int32_t i : bodies_) before_.push_back(all.motion(i));
  }
  template <class Bodies>
  void restore_motions(Bodies& all) const {
    for (std::size_t k = 0; k < bodies_.size(); ++k) all.set(bodies_[k], before_[k]);
  }
  template <class Bodies>
  void start_again(Bodies& all) {
    restore_motions(all);
    each_row([&](std::size_t j, std::size_t k, const joint_line&, real& r) {
      r = start_[first_[j] + k];
    });
    move_to_bounds(all);
    factorized_ = false;
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
    bool beyond = false;
    each_row([&](std::size_t, std::size_t, const joint_line& x, real& r) {
      beyond = beyond || r < x.least || r > x.most;
    });
    if (!beyond) return;
    restore_motions(all);
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      r = std::clamp(r, x.least, x.most);
      push(all, j, x, r - start_[first_[j] + k]);
    });
  }

  plain_vector<joint_view> joints_;
  plain_vector<std::size_t> first_;  ///< row of each joint
  plain_vector<std::int32_t> bodies_;
  plain_vector<real> inverse_mass_;
  plain_vector<mat3> inverse_inertia_;
  plain_vector<articulated_system::tie> ties_;
  plain_vector<bound> held_;  ///< by rows
  plain_vector<real> start_, residuals_;
  plain_vector<body_motion> before_;
  articulated_system system_;
  plain_vector<real> rest_;
  real scale_ = 0;          ///< of velocities
  real contradiction_ = 0;  ///< the largest residual of a row that depends on others
  bool factorized_ = false, stale_ = false;
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
  /// After the last solve() of a step.
  void share_loads() {
    for (articulation& one : all_) one.share_loads();
  }
  /// The rows have changed since the last solve().
  void renew() {
    for (articulation& one : all_) one.renew();
  }
  [[nodiscard]] bool empty() const { return all_.empty(); }

 private:
  std::vector<articulation> all_;
  disjoint_sets sets_;
};

}  // namespace talus::detail
