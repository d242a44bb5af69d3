#pragma once
// Newton's method for a contact problem by bodies: the size of the factorization grows with the
// bodies and the pairs that touch, instead of the pairs of contacts that share a body.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/solver/direct/body_elimination.hpp"
#include "talus/solver/direct/body_problem.hpp"

namespace talus::detail {

/// Semi-smooth Newton steps on the function of Alart and Curnier (1991) for the problem with u = W
/// r + q + alpha (r - centre), like those of assembled_newton. The changes of impulse are
/// eliminated contact by contact, which the proximal term permits: the remaining unknowns are the
/// changes of velocity, (I + M^-1 J^T D J) dv = M^-1 J^T d with blocks D of 3 x 3.
class body_newton {
 public:
  /// Floating-point operations of a step for each contact, besides the factorization.
  static constexpr double per_contact = 2500;

  /// `budget`: floating-point operations available for linear systems; decreases by the operations
  /// used.
  body_newton(const body_problem& p, double& budget)
      : p_(&p),
        budget_(&budget),
        open_(static_cast<std::size_t>(p.contacts_count()), 1),
        weak_(open_.size(), 0) {}

  /// Full Newton steps from r, until the residual is at most `enough` or `accuracy` times |r -
  /// centre|; else returns the best of `steps`. Returns whether it converged.
  bool solve(contact_vector& r, const contact_vector& centre, real alpha, real accuracy,
             real enough, int steps) {
    alpha_ = alpha;
    steps_ = 0;
    real best = residual(r, centre);
    contact_vector best_r = r;
    while (steps_ < steps) {
      ++steps_;
      if (!direction(r)) break;
      r += step_;
      const real now = residual(r, centre);
      if (now < best) best = now, best_r = r;
      if (now <= std::max(enough, accuracy * (r - centre).norm())) return true;
    }
    r = best_r;
    return false;
  }
  /// Whether weak contacts keep their impulses, because the system with all of them is too
  /// expensive.
  [[nodiscard]] bool keeps_weak() const { return keeps_weak_; }
  /// Whether the last system was too expensive for the budget.
  [[nodiscard]] bool too_dear() const { return too_dear_; }
  /// Linear systems solved by the last call.
  [[nodiscard]] int steps() const { return steps_; }

 private:
  /// The value of Coulomb's law at one contact. Open: f = r; sticking: f = rho u; sliding: f = (rho
  /// u_n, r_t - mu y_n y_t / |y_t|), with y = r - rho u.
  struct law {
    bool open = false, sticks = false;
    vec3 f{0, 0, 0};
    real c = 1, s = 0, turn = 0;  ///< the direction of y_t, and mu y_n / |y_t|
  };
  [[nodiscard]] real rho(int i) const { return 3 / (trace((*p_)[i].own) + 3 * alpha_); }
  [[nodiscard]] law law_of(int i, const contact_vector& r) const {
    const vec3 &ri = r(i), &ui = u_(i), y = ri - rho(i) * ui;
    const real mu = (*p_)[i].mu;
    law l;
    if (y[0] <= 0) {
      l.open = true;
      l.f = ri;
      return l;
    }
    const real t = portable::hypot(y[1], y[2]);
    l.sticks = mu > 0 && t <= mu * y[0];
    l.f = rho(i) * ui;
    if (l.sticks) return l;
    if (t > 0) l.c = y[1] / t, l.s = y[2] / t, l.turn = mu * y[0] / t;
    l.f[1] = ri[1] - l.turn * y[1], l.f[2] = ri[2] - l.turn * y[2];
    return l;
  }
  real residual(const contact_vector& r, const contact_vector& centre) {
    p_->velocity(r, u_);
    u_.add(alpha_, r);
    u_.add(-alpha_, centre);
    real sum = 0;
    for (int i = 0; i < r.contacts(); ++i)
      if (!weak_[static_cast<std::size_t>(i)]) sum += law_of(i, r).f.squaredNorm();
    return std::sqrt(sum);
  }

  /// The change of a contact's impulse for a change of its velocity: dr = d - D du.
  void response_of(int i, const law& l, vec3& d, mat3& D) const {
    D = diagonal_matrix(1 / alpha_);
    d = -(1 / (alpha_ * rho(i))) * l.f;
    if (l.sticks) return;
    const real mu = (*p_)[i].mu, e1 = -l.s, e2 = l.c;  // across the direction of sliding
    const real less = (1 - alpha_ * rho(i)) * l.turn;
    const real along =
        l.c * (l.f[1]) + l.s * l.f[2] + (1 - alpha_ * rho(i)) * mu * l.f[0] / (alpha_ * rho(i));
    const real across = (e1 * l.f[1] + e2 * l.f[2]) / (1 - less);
    d[1] = -(along * l.c + across * e1), d[2] = -(along * l.s + across * e2);
    const real k = rho(i) * l.turn / (1 - less);
    D(1, 0) = mu * l.c / alpha_, D(2, 0) = mu * l.s / alpha_;
    D(1, 1) = k * e1 * e1, D(1, 2) = D(2, 1) = k * e1 * e2, D(2, 2) = k * e2 * e2;
  }

  /// The Newton step from r; u_ belongs to it.
  bool direction(const contact_vector& r) {
    const int n = r.contacts();
    linearize(r);
    while (!assemble()) {
      if (analyse()) continue;
      if (!keep_weak(r)) return false;
      linearize(r);
    }
    const double cost = system_.cost() + per_contact * n;
    if (too_dear_ = cost > *budget_; too_dear_) return false;
    *budget_ -= cost;
    if (!system_.factorize()) return false;
    system_.solve(moved_);
    step_ = given_;
    for (int i = 0; i < n; ++i)
      if (enters(i)) step_(i) -= response_[at(i)] * p_->relative(i, moved_);
    return step_.is_finite();
  }
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] bool enters(int i) const { return !open_[at(i)] && !weak_[at(i)]; }
  void linearize(const contact_vector& r) {
    const int n = r.contacts();
    given_.resize(n);
    response_.resize(at(n));
    moved_.assign(p_->bodies().size(), body_vector{});
    for (int i = 0; i < n; ++i) {
      given_(i) = {0, 0, 0};
      if (weak_[at(i)]) continue;
      const law l = law_of(i, r);
      open_[at(i)] = l.open;
      if (l.open)
        given_(i) = -r(i);
      else
        response_of(i, l, given_(i), response_[at(i)]);
      p_->add_force(i, given_(i), moved_);
    }
    p_->times_inverse_mass(moved_);
  }
  /// Finds an order for the contacts in the system; false if the system is too expensive.
  bool analyse() {
    plain_vector<char> out = open_;
    for (std::size_t k = 0; k < out.size(); ++k) out[k] |= weak_[k];
    const elimination_order order(p_->graph(out), *budget_ / (4 * body_elimination::product));
    too_dear_ = !order.possible();
    if (!too_dear_) system_ = body_elimination(order);
    return !too_dear_;
  }
  /// Removes contacts that bear little of the load of both their bodies, as between spheres side by
  /// side under a plate: sweeps suffice for these. False if they are already removed.
  bool keep_weak(const contact_vector& r) {
    if (std::exchange(keeps_weak_, true)) return false;
    plain_vector<real> most(p_->bodies().size(), 0);
    for (int i = 0; i < r.contacts(); ++i)
      for (const std::int32_t body : {(*p_)[i].a, (*p_)[i].b})
        if (body >= 0) most[at(body)] = std::max(most[at(body)], r(i)[0]);
    for (int i = 0; i < r.contacts(); ++i) {
      const auto [a, b] = std::pair{(*p_)[i].a, (*p_)[i].b};
      if (a >= 0 && b >= 0) weak_[at(i)] = r(i)[0] < 1e-3 * std::min(most[at(a)], most[at(b)]);
    }
    return true;
  }
  /// I + M^-1 J^T D J; false if bodies touch that are not known to touch.
  bool assemble() {
    if (system_.bodies() == 0) return false;
    system_.clear();
    for (int i = 0; i < p_->contacts_count(); ++i) {
      if (enters(i) && !enter((*p_)[i], response_[at(i)])) return false;
    }
    system_.each_block([&](std::int32_t body, body_block& b) {
      const body_problem::body& of = p_->bodies()[static_cast<std::size_t>(body)];
      for (int j = 0; j < 6; ++j) {
        const vec3 turn = of.inverse_inertia * vec3(b(3, j), b(4, j), b(5, j));
        for (int k = 0; k < 3; ++k) b(k, j) *= of.inverse_mass, b(3 + k, j) = turn[k];
      }
    });
    for (std::int32_t k = 0; static_cast<std::size_t>(k) < p_->bodies().size(); ++k)
      for (int j = 0; j < 6; ++j) system_.diagonal(k)(j, j) += 1;
    return true;
  }
  /// Adds J^T D J of one contact.
  bool enter(const body_problem::contact& c, const mat3& D) {
    const mat3 world = c.axes.transpose() * D * c.axes;
    const auto add = [&](body_block& to, const vec3& arm_of_row, const vec3& arm, real sign) {
      const mat3 row = sign * cross_matrix(arm_of_row), right = -(world * cross_matrix(arm));
      const mat3 below = row * world, corner = row * right;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          to(i, j) += sign * world(i, j), to(i, 3 + j) += sign * right(i, j);
          to(3 + i, j) += below(i, j), to(3 + i, 3 + j) += corner(i, j);
        }
    };
    if (c.a >= 0) add(system_.diagonal(c.a), c.arm_a, c.arm_a, 1);
    if (c.b >= 0) add(system_.diagonal(c.b), c.arm_b, c.arm_b, 1);
    if (c.a >= 0 && c.b >= 0) {
      const auto [ab, ba] = system_.pair(c.a, c.b);
      if (ab == nullptr) return false;
      add(*ab, c.arm_a, c.arm_b, -1);
      add(*ba, c.arm_b, c.arm_a, -1);
    }
    return true;
  }

  const body_problem* p_;
  double* budget_;
  body_elimination system_;
  real alpha_ = 0;
  int steps_ = 0;
  bool too_dear_ = false, keeps_weak_ = false;
  contact_vector u_, step_, given_;
  plain_vector<mat3> response_;
  plain_vector<char> open_, weak_;
  plain_vector<body_vector> moved_;
};

}  // namespace talus::detail
