#pragma once
// Impulses that hold bodies at rest on each other, found from the top down: stacks, walls,
// pyramids.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/coulomb_block.hpp"
#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/natural_map.hpp"
#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/solver/direct/body_elimination.hpp"
#include "talus/solver/direct/support_graph.hpp"

namespace talus::detail {

/// A contact supports the upper of its bodies. Once the impulses on a body from above are known,
/// those of its supports follow from its equilibrium alone, as if the bodies below could not move:
/// a system of six equations. So one pass over the bodies, each after all those that it supports,
/// gives impulses for the whole island. If all bodies can be at rest on each other, these impulses
/// solve the contact problem exactly, because no contact slips or parts; Gauss-Seidel would need as
/// many sweeps as the square of the bodies above each other. Contacts that support neither body
/// (side by side) keep their impulses.
class support_balance : public support_graph {
 public:
  /// The contacts of an island, at the velocities of `s`, which contain their impulses.
  support_balance(const plain_vector<island_contact>& contacts, const solver_state& s)
      : support_graph(contacts, s), r_(static_cast<int>(contacts.size())) {
    for (const solver_body& b : s.bodies) v_.push_back({b.v, b.w});
    for (std::size_t i = 0; i < contacts.size(); ++i)
      r_(static_cast<int>(i)) = contacts[i].axes * contacts[i].impulse;
  }
  /// Improves the impulses. Changes of velocity below `least` do not matter. Returns the fraction
  /// of the error that is left; above a half, or if they may add energy, 1: then they are not to be
  /// used. Gives up early with 1 if many of the uppermost bodies cannot rest on those below, as in
  /// a pile of spheres, and if many bodies are `fast`, as in a heap that moves. `wholly`: or if any
  /// body cannot rest. If bodies cannot rest with the impulses that sweeps have left between bodies
  /// side by side, as after an impact, it tries without these.
  real solve(real least, real fast, bool wholly) {
    least_ = least;
    if (flows(fast)) return 1;
    find_scale();
    const real before = error();
    const plain_vector<body_motion> start = v_;
    for (bool again = false;; again = true) {
      for (support& c : supports_) c.open = r_(c.contact)[0] == 0 && contact(c).target_velocity < 0;
      if (!find_rest()) return 1;
      if (balance_all(wholly)) {
        const real after = error();
        if (after <= 1e-3 * before || (after < 0.5 * before && gained(start) <= 0))
          return after / before;
      }
      if (again || !part_neighbours(start)) return 1;
    }
  }
  [[nodiscard]] bool changes(std::size_t i) const {
    return r_(static_cast<int>(i)) != (*contacts_)[i].axes * (*contacts_)[i].impulse;
  }
  /// The impulse on a of a contact, in the world.
  [[nodiscard]] vec3 impulse(std::size_t i) const {
    return (*contacts_)[i].axes.transpose() * r_(static_cast<int>(i));
  }

 private:
  static constexpr int most_rounds = 6, most_sweeps = 30;
  /// Bodies after which a balance may be given up.
  static constexpr std::size_t few = 64;

  /// From the top down. Returns false if too many bodies cannot rest, `wholly`: if any cannot.
  [[nodiscard]] bool balance_all(bool wholly) {
    std::size_t balanced = 0, moving = 0;
    for (const std::int32_t body : order_) {
      if (many(moving, ++balanced)) return false;
      balance(body);
      if (!still(body, v_[at(body)])) {
        if (wholly) return false;
        ++moving;
      }
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
        if (const support& c = supports_[k]; c.below >= 0) {
          const vec3 change = r_(c.contact) - contact(c).axes * contact(c).impulse;
          if (change != vec3(0, 0, 0))
            apply(c.below, contact(c).axes.transpose() * (c.sign == 1 ? vec3(-change) : change),
                  arm_below(c));
        }
    }
    return true;
  }
  /// Begins again, without impulses of contacts that support neither body. Returns whether there
  /// were any.
  [[nodiscard]] bool part_neighbours(const plain_vector<body_motion>& start) {
    v_ = start;
    plain_vector<char> supports(contacts_->size(), 0);
    for (const support& c : supports_) supports[at(c.contact)] = 1;
    bool any = false;
    for (std::size_t i = 0; i < contacts_->size(); ++i) {
      const island_contact& c = (*contacts_)[i];
      vec3& r = r_(static_cast<int>(i));
      r = supports[i] ? vec3(c.axes * c.impulse) : vec3(0, 0, 0);
      if (supports[i] || c.impulse == vec3(0, 0, 0)) continue;
      any = true;
      if (moves(c.a)) apply(c.a, -c.impulse, c.arm_a);
      if (moves(c.b)) apply(c.b, c.impulse, c.arm_b);
    }
    return any;
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
  /// Whether the balance fails with so many bodies of `all` that cannot rest.
  [[nodiscard]] static bool many(std::size_t moving, std::size_t all) {
    return all >= few && moving > all / 8;
  }
  /// Whether many bodies are faster than that on what supports them.
  [[nodiscard]] bool flows(real fast) const {
    std::size_t fast_ones = 0;
    for (const std::int32_t body : order_)
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
        if (const support& c = supports_[k];
            r_(c.contact)[0] > 0 && velocity(c, v_[at(body)], v_).squaredNorm() > fast * fast) {
          ++fast_ones;
          break;
        }
    return fast_ones > order_.size() / 8;
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
      v.w += s_->bodies[at(body)].inverse_inertia * turn;
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
      if (c.friction > 0) u[0] += c.friction * portable::hypot(u[1], u[2]);
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

  /// Calls f(support, axis, direction).
  template <class F>
  void each_direction(std::int32_t body, real length, F&& f) const {
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
      const support& c = supports_[k];
      if (c.open) continue;
      for (int j = 0; j < (contact(c).friction > 0 ? 3 : 1); ++j) f(c, j, direction(c, j, length));
    }
  }
  /// G^T G with G for all directions.
  [[nodiscard]] body_block gram(std::int32_t body, real length) const {
    body_block g;
    each_direction(body, length,
                   [&](const support&, int, const body_vector& d) { add_square(g, d); });
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
  [[nodiscard]] bool still(std::int32_t body, const body_motion& own) const {
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
      const support& c = supports_[k];
      const vec3 u = velocity(c, own, rest_);
      const bool holds = c.open                    ? u[0] >= -least_
                         : contact(c).friction > 0 ? u.squaredNorm() <= least_ * least_
                                                   : u[0] * u[0] <= least_ * least_;
      if (!holds) return false;
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
  /// which the supports neither part nor slip, as far as possible. Returns false, and gives up, if
  /// it is not possible for many.
  [[nodiscard]] bool find_rest() {
    rest_ = v_;
    find_mean_velocities();
    std::size_t found = 0, moving = 0;
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
          ++found;
          continue;
        }
      }
      const real length = length_of(body);
      bool rests = still(body, own);
      for (int round = 0; round < most_rounds && !rests; ++round) {
        if (round > 0) close(body, own);
        if (!factorize(pivot_, gram(body, length))) continue;
        body_vector change = opposed(body, length, own);
        pivot_.solve<1>(change.data());
        own.v += vec3(change[0], change[1], change[2]);
        own.w += 1 / length * vec3(change[3], change[4], change[5]);
        rests = still(body, own);
      }
      if (!rests) ++moving;
      if (many(moving, ++found)) return false;
    }
    return true;
  }
  /// Supports that the body approaches within the step, at this motion.
  void close(std::int32_t body, const body_motion& own) {
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k)
      if (support& c = supports_[k]; c.open && velocity(c, own, rest_)[0] < -least_) c.open = false;
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
    if (!factorize(pivot_, product)) return;
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
      all = c.open ? velocity(c)[0] >= -least_
                   : portable::hypot(r[1], r[2]) <= contact(c).friction * r[0];
    }
    if (all) return;
    own_.clear();
    for (std::size_t k = first; k < end; ++k) {
      const support& c = supports_[k];
      const mat3 turning = contact(c).axes * cross_matrix(arm(c));
      mat3 own = turning * inverse_inertia(body) * turning.transpose();
      for (int i = 0; i < 3; ++i) own(i, i) += inverse_mass(body);
      own_.emplace_back().set(own);
    }
    for (int sweep = 0; sweep < most_sweeps && !all; ++sweep) {
      all = true;
      for (std::size_t k = first; k < end; ++k) {
        const support& c = supports_[k];
        const vec3 now = r_(c.contact);
        const vec3 next = own_[k - first].solve(now, velocity(c), contact(c).friction);
        if (!all_finite(next)) continue;
        all = all && inverse_mass(body) * (next - now).norm() <= 0.1 * least_;
        change(c, next - now);
      }
    }
  }

  contact_vector r_;
  plain_vector<body_motion> v_;     ///< with the impulses so far
  plain_vector<body_motion> rest_;  ///< if it rests on the bodies below
  body_pivot pivot_;
  plain_vector<coulomb_block> own_;  ///< of the supports of one body
  real least_ = 0, rho_ = 1;
};

}  // namespace talus::detail
