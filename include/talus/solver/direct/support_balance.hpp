#pragma once
// Impulses that hold bodies at rest on each other, found from the top down: stacks, walls,
// pyramids.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/coulomb.hpp"
#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/natural_map.hpp"
#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/body_elimination.hpp"

namespace talus::detail {

/// A contact supports the upper of its bodies. Once the impulses on a body from above are known,
/// those of its supports follow from its equilibrium alone, as if the bodies below could not move:
/// a system of six equations. So one pass over the bodies, each after all those that it supports,
/// gives impulses for the whole island. If all bodies can be at rest on each other, these impulses
/// solve the contact problem exactly, because no contact slips or parts; Gauss-Seidel would need as
/// many sweeps as the square of the bodies above each other. Contacts that support neither body
/// (side by side) keep their impulses.
template <class State>
class support_balance {
 public:
  /// The contacts of an island, at the velocities of `s`, which contain their impulses.
  support_balance(const plain_vector<island_contact>& contacts, const State& s)
      : contacts_(&contacts), s_(&s), r_(static_cast<int>(contacts.size())) {
    v_.resize(s.bodies.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const island_contact& c = contacts[i];
      r_(static_cast<int>(i)) = c.axes * c.impulse;
      for (const std::int32_t end : {c.a, c.b})
        if (end >= 0) v_[at(end)] = {v_of(s.bodies[at(end)]), w_of(s.bodies[at(end)])};
    }
    find_supports();
    find_order();
  }
  /// Bodies above each other, at most.
  [[nodiscard]] int rows() const { return rows_; }

  /// Improves the impulses. False if their error is not less than half of what it was, or if they
  /// may add energy: then they are not to be used. Changes of velocity below `least` do not matter.
  bool solve(real least) {
    least_ = least;
    find_scale();
    const real before = error();
    const plain_vector<body_motion> start = v_;
    for (support& c : supports_)
      c.open = r_(c.contact)[0] == 0 && velocity(c, v_[at(c.body)], v_)[0] > least_;
    find_rest();
    for (const std::int32_t body : order_) {
      balance(body);
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
        if (const support& c = supports_[k]; c.below >= 0) {
          const vec3 change = r_(c.contact) - contact(c).axes * contact(c).impulse;
          if (change != vec3(0, 0, 0))
            apply(c.below, contact(c).axes.transpose() * (c.sign == 1 ? vec3(-change) : change),
                  arm_below(c));
        }
    }
    const real after = error();
    return after <= 1e-3 * before || (after < 0.5 * before && gained(start) <= 0);
  }
  [[nodiscard]] bool changes(std::size_t i) const {
    return r_(static_cast<int>(i)) != (*contacts_)[i].axes * (*contacts_)[i].impulse;
  }
  /// The impulse on a of a contact, in the world.
  [[nodiscard]] vec3 impulse(std::size_t i) const {
    return (*contacts_)[i].axes.transpose() * r_(static_cast<int>(i));
  }

 private:
  struct support {
    std::int32_t contact, body, below;
    real sign;          ///< of the impulse of the contact, as an impulse on `body`
    bool open = false;  ///< does not carry
  };
  /// Contacts whose normal is closer to the horizontal support neither body.
  static constexpr real least_slope = 0.05;
  static constexpr int most_rounds = 6, most_sweeps = 30;
  /// Of the trace of a matrix, added to its diagonal, because supports may leave directions free.
  static constexpr real shift = 1e-9;

  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] const island_contact& contact(const support& c) const {
    return (*contacts_)[at(c.contact)];
  }
  [[nodiscard]] const vec3& arm(const support& c) const {
    return c.sign == 1 ? contact(c).arm_a : contact(c).arm_b;
  }
  [[nodiscard]] const vec3& arm_below(const support& c) const {
    return c.sign == 1 ? contact(c).arm_b : contact(c).arm_a;
  }
  [[nodiscard]] real inverse_mass(std::int32_t i) const {
    return real(s_->bodies[at(i)].inverse_mass);
  }
  [[nodiscard]] mat3 inverse_inertia(std::int32_t i) const {
    return at(i) >= s_->first_tensor
               ? s_->tensor(at(i))
               : diagonal_matrix<real>(real(s_->bodies[at(i)].inverse_inertia));
  }
  [[nodiscard]] bool moves(std::int32_t i) const { return i >= 0 && inverse_mass(i) != 0; }

  void find_supports() {
    const vec3 up = -1 / s_->fall.norm() * s_->fall;
    plain_vector<std::uint32_t> count(s_->bodies.size() + 1, 0);
    const auto each = [&](auto&& f) {
      for (std::size_t i = 0; i < contacts_->size(); ++i) {
        const island_contact& c = (*contacts_)[i];
        const real slope = c.axes(0, 0) * up[0] + c.axes(0, 1) * up[1] + c.axes(0, 2) * up[2];
        const auto number = static_cast<std::int32_t>(i);
        if (slope > least_slope && moves(c.a))
          f(support{number, c.a, moves(c.b) ? c.b : -1, 1});
        else if (slope < -least_slope && moves(c.b))
          f(support{number, c.b, moves(c.a) ? c.a : -1, -1});
      }
    };
    each([&](const support& c) { ++count[at(c.body) + 1]; });
    for (std::size_t k = 1; k < count.size(); ++k) count[k] += count[k - 1];
    first_ = count;
    supports_.resize(count[count.size() - 1]);
    each([&](const support& c) { supports_[count[at(c.body)]++] = c; });
  }
  /// Each body after those that it supports; a circle of bodies is entered anywhere.
  void find_order() {
    const std::size_t bodies = s_->bodies.size();
    plain_vector<std::int32_t> loads(bodies, 0), row(bodies, 1);
    for (const support& c : supports_)
      if (c.below >= 0) ++loads[at(c.below)];
    const auto supported = [&](std::size_t i) { return first_[i] < first_[i + 1]; };
    std::size_t left = 0;
    for (std::size_t i = 0; i < bodies; ++i) {
      if (!supported(i)) continue;
      ++left;
      if (loads[i] == 0) order_.push_back(static_cast<std::int32_t>(i));
    }
    std::size_t next = 0;
    for (std::size_t done = 0; done < left; ++done) {
      if (done == order_.size()) {
        while (!supported(next) || loads[next] <= 0) ++next;
        loads[next] = 0;
        order_.push_back(static_cast<std::int32_t>(next));
      }
      const std::int32_t body = order_[done];
      rows_ = std::max(rows_, row[at(body)]);
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
        const std::int32_t below = supports_[k].below;
        if (below < 0) continue;
        row[at(below)] = std::max(row[at(below)], row[at(body)] + 1);
        if (--loads[at(below)] == 0 && supported(at(below))) order_.push_back(below);
      }
    }
  }

  [[nodiscard]] static vec3 of_point(const body_motion& v, const vec3& arm) {
    return v.v + v.w.cross(arm);
  }
  /// Velocity of a contact, where the given body moves as `own`, and the other as in `others`.
  [[nodiscard]] vec3 velocity(const support& c, const body_motion& own,
                              const plain_vector<body_motion>& others) const {
    const island_contact& i = contact(c);
    vec3 v = of_point(own, arm(c));
    const std::int32_t other = c.sign == 1 ? i.b : i.a;
    if (other >= 0) v -= of_point(c.below >= 0 ? others[at(other)] : v_[at(other)], arm_below(c));
    vec3 u = i.axes * (c.sign == 1 ? v : vec3(-v));
    u[0] -= i.target_velocity, u[1] += i.drive[0], u[2] += i.drive[1];
    return u;
  }
  /// With the body below at its velocity of rest.
  [[nodiscard]] vec3 velocity(const support& c) const { return velocity(c, v_[at(c.body)], rest_); }
  void apply(std::int32_t body, const vec3& impulse, const vec3& arm) {
    body_motion& v = v_[at(body)];
    v.v += inverse_mass(body) * impulse;
    const vec3 turn = arm.cross(impulse);
    if (at(body) >= s_->first_tensor)
      v.w += s_->tensor(at(body)) * turn;
    else
      v.w += real(s_->bodies[at(body)].inverse_inertia) * turn;
  }
  void change(const support& c, const vec3& by) {
    r_(c.contact) += by;
    apply(c.body, contact(c).axes.transpose() * (c.sign == 1 ? by : vec3(-by)), arm(c));
  }

  /// The natural residual of all contacts.
  [[nodiscard]] real error() const {
    real sum = 0;
    for (std::size_t i = 0; i < contacts_->size(); ++i) {
      const island_contact& c = (*contacts_)[i];
      vec3 v{0, 0, 0};
      if (c.a >= 0) v += of_point(v_[at(c.a)], c.arm_a);
      if (c.b >= 0) v -= of_point(v_[at(c.b)], c.arm_b);
      vec3 u = c.axes * v;
      u[0] -= c.target_velocity, u[1] += c.drive[0], u[2] += c.drive[1];
      if (c.friction > 0) u[0] += c.friction * std::hypot(u[1], u[2]);
      const vec3& r = r_(static_cast<int>(i));
      sum += (r - project_on_cone(r - rho_ * u, c.friction)).squaredNorm();
    }
    return std::sqrt(sum);
  }
  void find_scale() {
    real sum = 0;
    for (const support& c : supports_) sum += inverse_mass(c.body);
    rho_ = sum > 0 ? static_cast<real>(supports_.size()) / (3 * sum) : 1;
  }
  /// The change of kinetic energy, without the factor 1/2.
  [[nodiscard]] real gained(const plain_vector<body_motion>& start) const {
    real sum = 0;
    for (const std::int32_t i : order_) {
      const body_motion &a = v_[at(i)], &b = start[at(i)];
      sum += (a.v.squaredNorm() - b.v.squaredNorm()) / inverse_mass(i);
      const mat3 inertia = inverse_inertia(i).inverse();
      sum += a.w.dot(inertia * a.w) - b.w.dot(inertia * b.w);
    }
    return sum;
  }

  // The directions of a body's velocity that its supports hold, as six numbers: those of its
  // velocity, and of its angular velocity times the radius of gyration.

  [[nodiscard]] real length_of(std::int32_t body) const {
    return std::sqrt(3 * inverse_mass(body) / trace(inverse_inertia(body)));
  }
  /// Calls f(support, axis, direction).
  template <class F>
  void each_direction(std::int32_t body, real length, F&& f) const {
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
      const support& c = supports_[k];
      if (c.open) continue;
      const island_contact& i = contact(c);
      for (int j = 0; j < (i.friction > 0 ? 3 : 1); ++j) {
        const vec3 axis = c.sign * i.axes.row(j), turn = (1 / length) * arm(c).cross(axis);
        f(c, j, body_vector{axis[0], axis[1], axis[2], turn[0], turn[1], turn[2]});
      }
    }
  }
  /// G^T G with G for all directions.
  [[nodiscard]] body_block gram(std::int32_t body, real length) const {
    body_block g;
    each_direction(body, length, [&](const support&, int, const body_vector& d) {
      for (std::size_t j = 0; j < 6; ++j)
        for (std::size_t k = 0; k < 6; ++k) g.at[6 * j + k] += d[j] * d[k];
    });
    return g;
  }
  /// Minus G^T times the velocities.
  [[nodiscard]] body_vector opposed(std::int32_t body, real length, const body_motion& own) const {
    body_vector sum{};
    vec3 u{0, 0, 0};
    each_direction(body, length, [&](const support& c, int axis, const body_vector& d) {
      if (axis == 0) u = velocity(c, own, rest_);
      for (std::size_t j = 0; j < 6; ++j) sum[j] -= u[axis] * d[j];
    });
    return sum;
  }
  [[nodiscard]] bool factorize(body_block b) {
    real sum = 0;
    for (int j = 0; j < 6; ++j) sum += b(j, j);
    for (int j = 0; j < 6; ++j) b(j, j) += shift * sum;
    return sum > 0 && pivot_.factorize(b);
  }
  [[nodiscard]] bool still(std::int32_t body, const body_motion& own) const {
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
      const vec3 u = velocity(supports_[k], own, rest_);
      const bool grips = contact(supports_[k]).friction > 0;
      if ((grips ? u.squaredNorm() : u[0] * u[0]) > least_ * least_) return false;
    }
    return true;
  }
  [[nodiscard]] bool all_grip(std::int32_t body) const {
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
      if (contact(supports_[k]).friction == 0) return false;
    return true;
  }

  /// Bodies that slide freely move with the mean velocity of all that they carry.
  void find_mean_velocities() {
    plain_vector<vec3> momentum(v_.size(), vec3(0, 0, 0));
    plain_vector<real> mass(v_.size(), 0);
    for (const std::int32_t body : order_) {
      mass[at(body)] += 1 / inverse_mass(body);
      momentum[at(body)] += 1 / inverse_mass(body) * v_[at(body)].v;
      const real share = 1 / static_cast<real>(first_[at(body) + 1] - first_[at(body)]);
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
        if (const std::int32_t below = supports_[k].below; below >= 0) {
          mass[at(below)] += share * mass[at(body)];
          momentum[at(below)] += share * momentum[at(body)];
        }
      if (!all_grip(body)) rest_[at(body)].v = 1 / mass[at(body)] * momentum[at(body)];
    }
  }
  /// The velocities at which bodies rest on those below, from the ground up: the least change for
  /// which the supports neither part nor slip, as far as possible.
  void find_rest() {
    rest_ = v_;
    find_mean_velocities();
    for (std::size_t k = order_.size(); k-- > 0;) {
      const std::int32_t body = order_[k];
      body_motion& own = rest_[at(body)];
      const support& c = supports_[first_[at(body)]];
      // Often they move as one.
      if (first_[at(body) + 1] - first_[at(body)] > 2 && all_grip(body)) {
        body_motion with{};
        if (c.below >= 0)
          with = {of_point(rest_[at(c.below)], arm_below(c) - arm(c)), rest_[at(c.below)].w};
        if (still(body, with)) {
          own = with;
          continue;
        }
      }
      if (still(body, own)) continue;
      const real length = length_of(body);
      if (!factorize(gram(body, length))) continue;
      body_vector change = opposed(body, length, own);
      pivot_.solve<1>(change.data());
      own.v += vec3(change[0], change[1], change[2]);
      own.w += 1 / length * vec3(change[3], change[4], change[5]);
    }
  }
  void balance(std::int32_t body) {
    if (still(body, v_[at(body)])) return;
    for (int round = 0; round < most_rounds; ++round) {
      hold(body);
      real most = 0;
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
        most = std::max(most, -r_(supports_[k].contact)[0]);
      if (most == 0) break;
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
        if (support& c = supports_[k]; - r_(c.contact)[0] >= 0.5 * most) {
          change(c, -r_(c.contact));
          c.open = true;
        }
    }
    settle(body);
  }
  /// The least impulses of the supports that are not open which make the velocities there zero, as
  /// far as possible: r = G z, where (G^T G) M^-1 (G^T G) z is minus G^T times the velocities.
  void hold(std::int32_t body) {
    const real length = length_of(body);
    const mat3 turning = (length * length / inverse_mass(body)) * inverse_inertia(body);
    const body_block g = gram(body, length);
    body_block moved, product;  // M^-1 (G^T G), times minus the mass
    for (int k = 0; k < 6; ++k) {
      const vec3 turn = turning * vec3(g(3, k), g(4, k), g(5, k));
      for (int j = 0; j < 3; ++j) moved(j, k) = -g(j, k), moved(3 + j, k) = -turn[j];
    }
    product.take(g, moved);
    if (!factorize(product)) return;
    for (int refinement = 0; refinement < 3; ++refinement) {
      body_vector z = opposed(body, length, v_[at(body)]);
      pivot_.solve<1>(z.data());
      for (real& x : z) x /= inverse_mass(body);
      vec3 by{0, 0, 0};
      const support* last = nullptr;
      const auto finish = [&] {
        if (last != nullptr) change(*last, by);
        by = {0, 0, 0};
      };
      each_direction(body, length, [&](const support& c, int axis, const body_vector& d) {
        if (axis == 0) finish(), last = &c;
        for (std::size_t j = 0; j < 6; ++j) by[axis] += d[j] * z[j];
      });
      finish();
    }
  }
  /// Gauss-Seidel over the supports of the body, where friction does not suffice or a support that
  /// was open has to carry.
  void settle(std::int32_t body) {
    const std::size_t first = first_[at(body)], end = first_[at(body) + 1];
    bool all = true;
    for (std::size_t k = first; k < end && all; ++k) {
      const support& c = supports_[k];
      const vec3& r = r_(c.contact);
      all =
          c.open ? velocity(c)[0] >= -least_ : std::hypot(r[1], r[2]) <= contact(c).friction * r[0];
    }
    for (int sweep = 0; sweep < most_sweeps && !all; ++sweep) {
      all = true;
      for (std::size_t k = first; k < end; ++k) {
        const support& c = supports_[k];
        const mat3 turning = contact(c).axes * cross_matrix(arm(c));
        mat3 own = turning * inverse_inertia(body) * turning.transpose();
        for (int i = 0; i < 3; ++i) own(i, i) += inverse_mass(body);
        const vec3 now = r_(c.contact);
        const vec3 next = solve_coulomb(own, velocity(c) - own * now, contact(c).friction);
        if (!all_finite(next)) continue;
        all = all && (next - now).norm() <= 1e-9 * next.norm();
        change(c, next - now);
      }
    }
  }

  const plain_vector<island_contact>* contacts_;
  const State* s_;
  contact_vector r_;
  plain_vector<body_motion> v_;     ///< with the impulses so far
  plain_vector<body_motion> rest_;  ///< if it rests on the bodies below
  plain_vector<support> supports_;  ///< by the supported body
  plain_vector<std::uint32_t> first_;
  plain_vector<std::int32_t> order_;
  body_pivot pivot_;
  int rows_ = 0;
  real least_ = 0, rho_ = 1;
};

}  // namespace talus::detail
