#pragma once
// Which contacts support which bodies, and the bodies in an order from the top down.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/body_elimination.hpp"

namespace talus::detail {

/// A contact whose normal rises by at least `least_slope` supports the upper of its bodies.
class support_graph {
 public:
  /// Bodies above each other, at most.
  [[nodiscard]] int rows() const { return rows_; }

 protected:
  struct support {
    std::int32_t contact, body, below;  ///< below = -1 if that cannot move
    real sign;                          ///< of the impulse of the contact, as an impulse on `body`
    bool open = false;                  ///< does not carry
  };
  /// Contacts whose normal is closer to the horizontal support neither body.
  static constexpr real least_slope = 0.05;
  /// The fraction of the trace of a matrix that is added to its diagonal, because supports may
  /// leave directions free.
  static constexpr real least_shift = 1e-9;

  support_graph(const plain_vector<island_contact>& contacts, const solver_state& s)
      : contacts_(&contacts), s_(&s) {
    find_supports();
    find_order();
  }

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
  [[nodiscard]] real inverse_mass(std::int32_t i) const { return s_->bodies[at(i)].inverse_mass; }
  [[nodiscard]] mat3 inverse_inertia(std::int32_t i) const {
    return at(i) >= s_->first_tensor ? s_->tensor(at(i))
                                     : diagonal_matrix<real>(s_->bodies[at(i)].inverse_inertia);
  }
  [[nodiscard]] bool moves(std::int32_t i) const { return i >= 0 && inverse_mass(i) != 0; }
  [[nodiscard]] bool supported(std::int32_t i) const { return first_[at(i)] < first_[at(i) + 1]; }
  /// The radius of gyration.
  [[nodiscard]] real length_of(std::int32_t body) const {
    return std::sqrt(3 * inverse_mass(body) / trace(inverse_inertia(body)));
  }
  [[nodiscard]] static vec3 of_point(const body_motion& v, const vec3& arm) {
    return v.v + v.w.cross(arm);
  }
  /// An axis of a contact as six numbers: of the velocity of the body, and of its angular velocity
  /// times `length`.
  [[nodiscard]] body_vector direction(const support& c, int axis, real length) const {
    const vec3 d = c.sign * contact(c).axes.row(axis), turn = (1 / length) * arm(c).cross(d);
    return {d[0], d[1], d[2], turn[0], turn[1], turn[2]};
  }
  /// Adds u u^T.
  static void add_square(body_block& g, const body_vector& u) {
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 6; ++k) g.at[6 * j + k] += u[j] * u[k];
  }
  [[nodiscard]] static bool factorize(body_pivot& pivot, body_block b, real shift = least_shift) {
    real sum = 0;
    for (int j = 0; j < 6; ++j) sum += b(j, j);
    for (int j = 0; j < 6; ++j) b(j, j) += shift * sum;
    return sum > 0 && pivot.factorize(b);
  }

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

  const plain_vector<island_contact>* contacts_;
  const solver_state* s_;
  plain_vector<support> supports_;  ///< by the supported body
  plain_vector<std::uint32_t> first_;
  plain_vector<std::int32_t> order_;  ///< those that are supported, from the top down

 private:
  int rows_ = 0;
};

}  // namespace talus::detail
