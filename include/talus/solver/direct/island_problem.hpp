#pragma once
// A few contacts of a time step as one assembled problem, ordered so that its band is narrow.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/direct/assembled.hpp"

namespace talus::detail {

/// Orders contacts along the chain of bodies that they connect (Cuthill and McKee 1969): contacts
/// of one body are then close together. Returns the order and the half bandwidth in contacts.
class contact_order {
 public:
  /// Immovable bodies do not connect.
  contact_order(const plain_vector<island_contact>& contacts, const solver_state& s)
      : bodies_of_(contacts.size(), {-1, -1}), first_(s.bodies.size() + 1, 0) {
    const std::size_t n = contacts.size();
    for (std::size_t i = 0; i < n; ++i) {
      auto& [a, b] = bodies_of_[i];
      for (const std::int32_t body : {contacts[i].a, contacts[i].b})
        if (body >= 0 && s.bodies[at(body)].inverse_mass != 0) {
          (a < 0 ? a : b) = body;
          ++first_[at(body) + 1];
        }
      if (b >= 0 && b < a) std::swap(a, b);
    }
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    contacts_of_.resize(first_.back());
    plain_vector<std::uint32_t> next = first_;
    for (std::uint32_t i = 0; i < n; ++i)
      for (const std::int32_t body : bodies_of_[i])
        if (body >= 0) contacts_of_[next[at(body)]++] = i;
    // Twice: the last contact of a search from anywhere lies at an end of the chain.
    search(0);
    search(order_.back());
    plain_vector<std::uint32_t> place(n);
    for (std::size_t k = 0; k < n; ++k) place[order_[k]] = static_cast<std::uint32_t>(k);
    for (std::size_t body = 0; body < s.bodies.size(); ++body) {
      std::uint32_t first = ~0u, last = 0;
      for (const auto i : of(body))
        first = std::min(first, place[i]), last = std::max(last, place[i]);
      if (first < last) half_ = std::max<std::size_t>(half_, last - first);
    }
  }
  [[nodiscard]] const plain_vector<std::uint32_t>& order() const { return order_; }
  [[nodiscard]] std::size_t half_bandwidth() const { return half_; }
  /// Contacts in a row from one end to the other.
  [[nodiscard]] std::size_t length() const { return length_; }

 private:
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t body) const {
    return {contacts_of_.data() + first_[body], contacts_of_.data() + first_[body + 1]};
  }
  void search(std::uint32_t start) {
    plain_vector<char> seen(bodies_of_.size(), 0), met(first_.size(), 0);
    order_.assign(1, start);
    seen[start] = 1;
    length_ = 0;
    for (std::size_t k = 0, level_end = 0; k < order_.size(); ++k) {
      if (k == level_end) level_end = order_.size(), ++length_;
      for (const std::int32_t body : bodies_of_[order_[k]]) {
        if (body < 0 || std::exchange(met[at(body)], char{1})) continue;
        for (const auto next : of(at(body)))
          if (!seen[next]) seen[next] = 1, order_.push_back(next);
      }
    }
  }

  plain_vector<std::array<std::int32_t, 2>> bodies_of_;  ///< that move, ascending
  plain_vector<std::uint32_t> first_;  ///< of each body in `contacts_of_`, and the end
  plain_vector<std::uint32_t> contacts_of_, order_;
  std::size_t half_ = 0, length_ = 0;
};

/// Assembles the problem of these contacts at the velocities of `s`, which contain their impulses;
/// `r` becomes those impulses in the axes of the contacts.
[[nodiscard]] inline assembled_problem assemble_island(const plain_vector<island_contact>& contacts,
                                                       const solver_state& s, contact_vector& r) {
  struct end {
    std::int32_t body;
    std::int32_t contact;
    mat3 turning;  // u = sign axes v + turning w
    real sign;
  };
  const std::size_t n = contacts.size();
  plain_vector<end> ends;
  ends.reserve(2 * n);
  contact_vector q(static_cast<int>(n));
  r.resize(static_cast<int>(n));
  plain_vector<real> mu(n);
  for (std::size_t i = 0; i < n; ++i) {
    const island_contact& c = contacts[i];
    vec3 u{-c.target_velocity, c.drive[0], c.drive[1]};
    const auto side = [&](std::int32_t body, const vec3& arm, real sign) {
      if (body < 0) return;
      const mat3 turning = -sign * (c.axes * cross_matrix(arm));
      const auto& moving = s.bodies[static_cast<std::size_t>(body)];
      u += sign * (c.axes * v_of(moving)) + turning * w_of(moving);
      if (moving.inverse_mass != 0)
        ends.push_back({body, static_cast<std::int32_t>(i), turning, sign});
    };
    side(c.a, c.arm_a, 1);
    side(c.b, c.arm_b, -1);
    q(static_cast<int>(i)) = u;
    r(static_cast<int>(i)) = c.axes * c.impulse;
    mu[i] = c.friction;
  }
  plain_vector<plain_pair<std::int64_t, std::uint32_t>> order;  // body, end
  for (const end& e : ends) order.emplace_back(e.body, static_cast<std::uint32_t>(order.size()));
  sort_values(order);
  plain_vector<delassus_block> blocks;
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    while (last < order.size() && order[last].first == order[first].first) ++last;
    const auto body = static_cast<std::size_t>(order[first].first);
    const real inverse_mass = s.bodies[body].inverse_mass;
    const mat3 inertia = body >= s.first_tensor
                             ? s.tensor(body)
                             : diagonal_matrix<real>(s.bodies[body].inverse_inertia);
    for (std::size_t i = first; i < last; ++i)
      for (std::size_t j = first; j < last; ++j) {
        const end &x = ends[order[i].second], &y = ends[order[j].second];
        const mat3& A = contacts[static_cast<std::size_t>(x.contact)].axes;
        const mat3& B = contacts[static_cast<std::size_t>(y.contact)].axes;
        blocks.push_back({x.contact, y.contact,
                          (x.sign * y.sign * inverse_mass) * (A * B.transpose()) +
                              x.turning * inertia * y.turning.transpose()});
      }
  }
  assembled_problem p = assemble(std::move(blocks), std::move(q), std::move(mu));
  contact_vector own;
  p.velocity(r, own);  // W r + q, with the present velocities for q
  p.q *= 2;
  p.q -= own;
  return p;
}

}  // namespace talus::detail
