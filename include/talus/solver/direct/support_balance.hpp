#pragma once
// Impulses that hold bodies at rest on each other, found from the top down: stacks, walls, pyramids.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/coulomb.hpp"
#include "talus/core/contact_vector.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/body_elimination.hpp"
#include "talus/solver/direct/body_problem.hpp"

namespace talus::detail {

/// A contact supports the upper of its bodies. Once the impulses on a body from above are known,
/// those of its supports follow from its equilibrium alone, as if the bodies below could not move:
/// a system of six equations. So one pass over the bodies, each after all those that it supports,
/// gives impulses for the whole island. If all bodies can be at rest on each other, these impulses
/// solve the contact problem exactly, because all contacts stick or touch without velocity; Gauss-
/// Seidel would need as many sweeps as the square of the bodies above each other. Contacts that
/// support neither body (side by side) get no impulse.
class support_balance {
 public:
  /// `fall` is the change of velocity by gravity in the step.
  support_balance(const body_problem& p, const vec3& fall) : p_(&p), v_(p.free()), rest_(v_) {
    const auto bodies = p.bodies().size();
    for (body_vector& v : rest_)
      for (int j = 0; j < 3; ++j) v[static_cast<std::size_t>(j)] -= fall[j];
    find_supports(fall);
    find_order(bodies);
  }
  /// Bodies above each other, at most.
  [[nodiscard]] int rows() const { return rows_; }

  /// `r` becomes the impulses.
  void solve(contact_vector& r) {
    r.set_zero(p_->contacts_count());
    for (const std::int32_t body : order_) {
      balance(body, r);
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
        const support& c = supports_[k];
        if (c.below >= 0) apply(c.below, c.turned.transpose() * -r(c.contact), c.arm_below);
      }
    }
  }

 private:
  struct support {
    std::int32_t contact, body, below;
    mat3 turned;  ///< the axes of the contact, for the impulse on `body`
    vec3 arm, arm_below;
    bool open = false;  ///< would have to pull
  };
  /// Contacts whose normal is closer to the horizontal support neither body.
  static constexpr real least_slope = 0.05;

  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

  void find_supports(const vec3& fall) {
    const vec3 up = -1 / fall.norm() * fall;
    plain_vector<std::size_t> count(p_->bodies().size() + 1, 0);
    const auto each = [&](auto&& f) {
      for (int i = 0; i < p_->contacts_count(); ++i) {
        const body_problem::contact& c = (*p_)[i];
        const real slope = c.axes(0, 0) * up[0] + c.axes(0, 1) * up[1] + c.axes(0, 2) * up[2];
        if (slope > least_slope && c.a >= 0)
          f(support{i, c.a, c.b, c.axes, c.arm_a, c.arm_b});
        else if (slope < -least_slope && c.b >= 0)
          f(support{i, c.b, c.a, -c.axes, c.arm_b, c.arm_a});
      }
    };
    each([&](const support& c) { ++count[at(c.body) + 1]; });
    for (std::size_t k = 1; k < count.size(); ++k) count[k] += count[k - 1];
    first_ = count;
    supports_.resize(count[count.size() - 1]);
    each([&](const support& c) { supports_[count[at(c.body)]++] = c; });
  }
  /// Each body after those that it supports; a circle of bodies is entered anywhere.
  void find_order(std::size_t bodies) {
    plain_vector<std::int32_t> loads(bodies, 0), row(bodies, 1);
    for (const support& c : supports_)
      if (c.below >= 0) ++loads[at(c.below)];
    for (std::size_t i = 0; i < bodies; ++i)
      if (loads[i] == 0) order_.push_back(static_cast<std::int32_t>(i));
    std::size_t next = 0;
    for (std::size_t done = 0; done < bodies; ++done) {
      if (done == order_.size()) {
        while (loads[next] <= 0) ++next;
        loads[next] = 0;
        order_.push_back(static_cast<std::int32_t>(next));
      }
      const std::int32_t body = order_[done];
      rows_ = std::max(rows_, row[at(body)]);
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
        const std::int32_t below = supports_[k].below;
        if (below < 0) continue;
        row[at(below)] = std::max(row[at(below)], row[at(body)] + 1);
        if (--loads[at(below)] == 0) order_.push_back(below);
      }
    }
  }

  [[nodiscard]] static vec3 of_point(const body_vector& v, const vec3& arm) {
    return vec3(v[0], v[1], v[2]) + vec3(v[3], v[4], v[5]).cross(arm);
  }
  /// Velocity of the contact, with the body below at rest.
  [[nodiscard]] vec3 velocity(const support& c) const {
    vec3 v = of_point(v_[at(c.body)], c.arm);
    if (c.below >= 0) v -= of_point(rest_[at(c.below)], c.arm_below);
    return c.turned * v + (*p_)[c.contact].offset;
  }
  void apply(std::int32_t body, const vec3& impulse, const vec3& arm) {
    const vec3 turn = arm.cross(impulse);
    body_vector d{impulse[0], impulse[1], impulse[2], turn[0], turn[1], turn[2]};
    p_->times_inverse_mass(at(body), d);
    for (std::size_t j = 0; j < 6; ++j) v_[at(body)][j] += d[j];
  }
  void change(const support& c, const vec3& by, contact_vector& r) {
    r(c.contact) += by;
    apply(c.body, c.turned.transpose() * by, c.arm);
  }

  void balance(std::int32_t body, contact_vector& r) {
    const std::size_t first = first_[at(body)], end = first_[at(body) + 1];
    if (first == end) return;
    for (int round = 0; round < most_rounds; ++round) {
      if (!hold(body, first, end, r)) break;
      bool pulls = false;
      for (std::size_t k = first; k < end; ++k)
        if (support& c = supports_[k]; r(c.contact)[0] < 0) {
          change(c, -r(c.contact), r);
          pulls = c.open = true;
        }
      if (!pulls) break;
    }
    settle(body, first, end, r);
  }
  /// The least impulses of the supports that are not open which make the velocities there zero, as
  /// far as possible: with G for all their directions, r = G z, where (G^T G) M^-1 (G^T G) z is
  /// minus G^T times the velocities. Lengths are in units of the body's radius of gyration. A small
  /// shift decides directions that the supports leave free. Returns whether there are any.
  bool hold(std::int32_t body, std::size_t first, std::size_t end, contact_vector& r) {
    const body_problem::body& b = p_->bodies()[at(body)];
    const real length = std::sqrt(3 * b.inverse_mass / trace(b.inverse_inertia));
    const mat3 turning = (length * length / b.inverse_mass) * b.inverse_inertia;
    body_block gram, product;
    bool any = false;
    const auto each_row = [&](auto&& f) {
      for (std::size_t k = first; k < end; ++k) {
        const support& c = supports_[k];
        if (c.open) continue;
        any = true;
        const mat3 arms = (-1 / length) * (c.turned * cross_matrix(c.arm));
        for (int i = 0; i < ((*p_)[c.contact].mu > 0 ? 3 : 1); ++i)
          f(c, i,
            body_vector{c.turned(i, 0), c.turned(i, 1), c.turned(i, 2), arms(i, 0), arms(i, 1),
                        arms(i, 2)});
      }
    };
    body_vector z;
    for (int refinement = 0; refinement < 2; ++refinement) {
      body_vector right{};
      if (refinement == 0) gram = body_block{};
      vec3 u{0, 0, 0};
      each_row([&](const support& c, int i, const body_vector& g) {
        if (i == 0) u = velocity(c);
        for (std::size_t j = 0; j < 6; ++j) right[j] -= u[i] * g[j];
        if (refinement > 0) return;
        for (int j = 0; j < 6; ++j)
          for (int k = 0; k < 6; ++k)
            gram(j, k) += g[static_cast<std::size_t>(j)] * g[static_cast<std::size_t>(k)];
      });
      if (!any) return false;
      if (refinement == 0) {
        body_block moved;  // M^-1 (G^T G), times the mass
        for (int k = 0; k < 6; ++k) {
          const vec3 turn = turning * vec3(gram(3, k), gram(4, k), gram(5, k));
          for (int j = 0; j < 3; ++j) moved(j, k) = gram(j, k), moved(3 + j, k) = turn[j];
        }
        product = body_block{};
        product.take(gram, moved);
        real sum = 0;
        for (int j = 0; j < 6; ++j) sum += product(j, j);
        for (int j = 0; j < 6; ++j) product(j, j) += shift * sum;
        if (!pivot_.factorize(product)) return false;
      }
      z = right;
      pivot_.solve<1>(z.data());
      for (real& x : z) x *= -1 / b.inverse_mass;  // `product` has the opposite sign
      vec3 by{0, 0, 0};
      const support* last = nullptr;
      const auto finish = [&] {
        if (last != nullptr) change(*last, by, r);
        by = {0, 0, 0};
      };
      each_row([&](const support& c, int i, const body_vector& g) {
        if (i == 0) finish(), last = &c;
        for (std::size_t j = 0; j < 6; ++j) by[i] += g[j] * z[j];
      });
      finish();
    }
    return true;
  }
  /// Gauss-Seidel over the supports of the body, where friction does not suffice or a support that
  /// was open has to carry.
  void settle(std::int32_t body, std::size_t first, std::size_t end, contact_vector& r) {
    const body_problem::body& b = p_->bodies()[at(body)];
    const auto good = [&](const support& c) {
      const vec3& now = r(c.contact);
      if (c.open) return velocity(c)[0] >= 0;
      return std::hypot(now[1], now[2]) <= (*p_)[c.contact].mu * now[0];
    };
    bool all = true;
    for (std::size_t k = first; k < end && all; ++k) all = good(supports_[k]);
    for (int sweep = 0; sweep < most_sweeps && !all; ++sweep) {
      all = true;
      for (std::size_t k = first; k < end; ++k) {
        const support& c = supports_[k];
        const mat3 turning = c.turned * cross_matrix(c.arm);
        mat3 own = turning * b.inverse_inertia * turning.transpose();
        for (int i = 0; i < 3; ++i) own(i, i) += b.inverse_mass;
        const vec3 now = r(c.contact);
        const vec3 next = solve_coulomb(own, velocity(c) - own * now, (*p_)[c.contact].mu);
        if (!all_finite(next)) continue;
        all = all && (next - now).norm() <= 1e-9 * next.norm();
        change(c, next - now, r);
      }
    }
  }

  static constexpr int most_rounds = 4, most_sweeps = 30;
  static constexpr real shift = -1e-13;

  const body_problem* p_;
  plain_vector<body_vector> v_;     ///< with the impulses so far
  plain_vector<body_vector> rest_;  ///< before the step
  plain_vector<support> supports_;  ///< by the supported body
  plain_vector<std::size_t> first_;
  plain_vector<std::int32_t> order_;
  body_pivot pivot_;
  int rows_ = 0;
};

}  // namespace talus::detail
