#pragma once
// A contact problem of a time step by its bodies: the Delassus operator of a plate on thousands of
// spheres is full, while the bodies hold few numbers each.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/coulomb.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/direct/assembled.hpp"
#include "talus/solver/direct/body_elimination.hpp"
#include "talus/solver/direct/island_problem.hpp"

namespace talus::detail {

/// The problem of assembled_problem, u = W r + q with W = J M^-1 J^T, where each row of J belongs
/// to one or two movable bodies. Contacts are those of an island, bodies their numbers from 0.
class body_problem {
 public:
  struct contact {
    std::int32_t a, b;  ///< movable bodies, else -1
    mat3 axes;          ///< rows: normal, two tangents
    vec3 arm_a, arm_b;
    vec3 offset;  ///< velocity at the contact from bodies outside the problem
    real mu;
    mat3 own;  ///< its block of W
  };
  struct body {
    real inverse_mass;
    mat3 inverse_inertia;
  };

  /// At the velocities of `s`, which contain the impulses of the contacts; `r` becomes those
  /// impulses in the axes of the contacts.
  body_problem(const plain_vector<island_contact>& contacts, const solver_state& s,
               contact_vector& r) {
    plain_vector<std::int32_t> numbers;  // of those that move
    for (std::size_t i = 0; i < s.bodies.size(); ++i) {
      const solver_body& b = s.bodies[i];
      numbers.push_back(b.inverse_mass != 0 ? static_cast<std::int32_t>(bodies_.size()) : -1);
      if (b.inverse_mass == 0) continue;
      bodies_.push_back({b.inverse_mass, i >= s.first_tensor
                                             ? s.tensor(i)
                                             : diagonal_matrix<real>(b.inverse_inertia)});
      free_.push_back({b.v[0], b.v[1], b.v[2], b.w[0], b.w[1], b.w[2]});
    }
    contacts_.reserve(contacts.size());
    r.resize(static_cast<int>(contacts.size()));
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const island_contact& c = contacts[i];
      contact one{-1,         -1,
                  c.axes,     c.arm_a,
                  c.arm_b,    {-c.target_velocity, c.drive[0], c.drive[1]},
                  c.friction, diagonal_matrix(real{0})};
      const auto enter = [&](std::int32_t of, std::int32_t& here, const vec3& arm, real sign) {
        if (of < 0) return;
        here = numbers[at(of)];
        if (here < 0) {
          const solver_body& b = s.bodies[at(of)];
          one.offset += sign * (c.axes * (b.v + b.w.cross(arm)));
          return;
        }
        const mat3 turning = c.axes * cross_matrix(arm);
        one.own += bodies_[at(here)].inverse_mass * (c.axes * c.axes.transpose()) +
                   turning * bodies_[at(here)].inverse_inertia * turning.transpose();
      };
      enter(c.a, one.a, c.arm_a, 1);
      enter(c.b, one.b, c.arm_b, -1);
      contacts_.push_back(one);
      r(static_cast<int>(i)) = c.axes * c.impulse;
    }
    // Without the impulses.
    contact_vector none = r;
    none *= -1;
    plain_vector<body_vector> v = free_;
    act(none, v);
    free_ = v;
    q_.resize(contacts_count());
    for (int i = 0; i < contacts_count(); ++i) q_(i) = velocity_at(i, free_);
    real sum = 0;
    for (const contact& c : contacts_) sum += trace(c.own);
    mean_ = sum > 0 ? sum / (3 * static_cast<real>(contacts_.size())) : 1;
  }

  [[nodiscard]] int contacts_count() const { return static_cast<int>(contacts_.size()); }
  [[nodiscard]] const contact& operator[](int i) const { return contacts_[at(i)]; }
  [[nodiscard]] const plain_vector<body>& bodies() const { return bodies_; }
  [[nodiscard]] const contact_vector& q() const { return q_; }
  [[nodiscard]] real mean_diagonal() const { return mean_; }

  /// The pairs of bodies that touch by contacts that are not `open`.
  [[nodiscard]] sparse_graph graph(const plain_vector<char>& open) const {
    plain_vector<plain_pair<std::int32_t, std::int32_t>> pairs;
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (const contact& c = contacts_[i]; !open[i] && c.a >= 0 && c.b >= 0)
        pairs.emplace_back(c.a, c.b), pairs.emplace_back(c.b, c.a);
    std::sort(pairs.begin(), pairs.end());
    sparse_graph g;
    std::size_t k = 0;
    for (std::int32_t i = 0; at(i) < bodies_.size(); ++i) {
      for (; k < pairs.size() && pairs[k].first == i; ++k)
        if (k == 0 || pairs[k] != pairs[k - 1]) g.column.push_back(pairs[k].second);
      g.start.push_back(static_cast<std::int32_t>(g.column.size()));
    }
    return g;
  }

  /// u = W r + q
  void velocity(const contact_vector& r, contact_vector& u) const {
    v_ = free_;
    act(r, v_);
    u.resize(contacts_count());
    for (int i = 0; i < contacts_count(); ++i) u(i) = velocity_at(i, v_);
  }
  /// |r - P(r - rho û)|, see natural_residual(); `u` is W r + q.
  [[nodiscard]] real residual(const contact_vector& r, const contact_vector& u, real rho) const {
    real sum = 0;
    for (int i = 0; i < contacts_count(); ++i) {
      const vec3 ri = r(i);
      vec3 v = u(i);
      const real mu = contacts_[at(i)].mu;
      v[0] += mu * portable::hypot(v[1], v[2]);
      sum += (ri - project_on_cone(ri - rho * v, mu)).squaredNorm();
    }
    return std::sqrt(sum);
  }

  /// Adds J^T r.
  void impulses(const contact_vector& r, plain_vector<body_vector>& p) const {
    for (int i = 0; i < contacts_count(); ++i) add_force(i, r(i), p);
  }
  void add_force(int i, const vec3& r, plain_vector<body_vector>& p) const {
    const contact& c = contacts_[at(i)];
    const vec3 force = c.axes.transpose() * r;
    if (c.a >= 0) add_force(p[at(c.a)], force, c.arm_a);
    if (c.b >= 0) add_force(p[at(c.b)], -force, c.arm_b);
  }
  /// Converts impulses to changes of velocity.
  void times_inverse_mass(plain_vector<body_vector>& p) const {
    for (std::size_t k = 0; k < bodies_.size(); ++k) times_inverse_mass(k, p[k]);
  }
  void times_inverse_mass(std::size_t k, body_vector& p) const {
    const vec3 turn = bodies_[k].inverse_inertia * vec3(p[3], p[4], p[5]);
    for (std::size_t j = 0; j < 3; ++j)
      p[j] *= bodies_[k].inverse_mass, p[3 + j] = turn[static_cast<int>(j)];
  }
  /// J v, without the velocity from bodies outside the problem.
  [[nodiscard]] vec3 relative(int i, const plain_vector<body_vector>& v) const {
    const contact& c = contacts_[at(i)];
    vec3 u{0, 0, 0};
    if (c.a >= 0) u += of_point(v[at(c.a)], c.arm_a);
    if (c.b >= 0) u -= of_point(v[at(c.b)], c.arm_b);
    return c.axes * u;
  }

  /// Gauss-Seidel, up or down the contacts.
  void sweep(contact_vector& r, bool down) const {
    v_ = free_;
    act(r, v_);
    plain_vector<body_vector> change(1);
    const int n = contacts_count();
    for (int k = 0; k < n; ++k) {
      const int i = down ? n - 1 - k : k;
      const contact& c = contacts_[at(i)];
      const vec3 now = solve_coulomb(c.own, velocity_at(i, v_) - c.own * r(i), c.mu);
      if (!all_finite(now)) continue;
      const vec3 force = c.axes.transpose() * vec3(now - r(i));
      const auto apply_impulse = [&](std::int32_t body, const vec3& by, const vec3& arm) {
        if (body < 0) return;
        body_vector d{};
        add_force(d, by, arm);
        times_inverse_mass(at(body), d);
        for (std::size_t j = 0; j < 6; ++j) v_[at(body)][j] += d[j];
      };
      apply_impulse(c.a, force, c.arm_a);
      apply_impulse(c.b, -force, c.arm_b);
      r(i) = now;
    }
  }

 private:
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  static void add_force(body_vector& p, const vec3& force, const vec3& arm) {
    const vec3 turn = arm.cross(force);
    for (std::size_t j = 0; j < 3; ++j)
      p[j] += force[static_cast<int>(j)], p[3 + j] += turn[static_cast<int>(j)];
  }
  static vec3 of_point(const body_vector& v, const vec3& arm) {
    return vec3(v[0], v[1], v[2]) + vec3(v[3], v[4], v[5]).cross(arm);
  }
  [[nodiscard]] vec3 velocity_at(int i, const plain_vector<body_vector>& v) const {
    return relative(i, v) + contacts_[at(i)].offset;
  }
  /// Applies impulses to velocities.
  void act(const contact_vector& r, plain_vector<body_vector>& v) const {
    p_.assign(bodies_.size(), body_vector{});
    impulses(r, p_);
    times_inverse_mass(p_);
    for (std::size_t k = 0; k < v.size(); ++k)
      for (std::size_t j = 0; j < 6; ++j) v[k][j] += p_[k][j];
  }

  plain_vector<contact> contacts_;
  plain_vector<body> bodies_;
  plain_vector<body_vector> free_;
  contact_vector q_;
  real mean_ = 1;
  mutable plain_vector<body_vector> v_, p_;
};

}  // namespace talus::detail
