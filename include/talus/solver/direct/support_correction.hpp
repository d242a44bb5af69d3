#pragma once
// The position correction of stacks, from the ground up.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/body_elimination.hpp"
#include "talus/solver/direct/isolated_island.hpp"
#include "talus/solver/direct/support_graph.hpp"

namespace talus::detail {

/// Gaps and overlaps of a stack add up: if all of its contacts close by a little, the top moves by
/// the sum, and a few sweeps cannot carry that through many rows. They move the rows unevenly,
/// which tilts the bodies. One pass from the ground up moves each body relative to those that
/// support it, which have moved already. The motion of a body is the least one that gives its
/// loaded supports their rates, and does not let the others come closer than theirs, as far as
/// possible. An island whose contacts are then further from their rates than before is not moved:
/// supports of one body that are almost parallel, but differ in their rates, as the sides of two
/// arches that touch, send it far away, and the bodies above further with each row.
class support_correction : support_graph {
 public:
  support_correction(const plain_vector<island_contact>& contacts, const solver_state& s)
      : support_graph(contacts, s), moved_(s.bodies.size()) {}

  /// False if a body that supports others has no support, so that nothing holds the stack.
  [[nodiscard]] bool stands() const {
    return std::all_of(supports_.begin(), supports_.end(),
                       [&](const support& c) { return c.below < 0 || supported(c.below); });
  }
  /// Finds displacements per time of the bodies that are slower than `fastest`; those below `least`
  /// do not matter.
  void solve(real fastest, real least) {
    for (support& c : supports_) c.open = !is_loaded(contact(c));
    for (std::size_t k = order_.size(); k-- > 0;)
      if (const std::int32_t body = order_[k]; v_of(s_->bodies[at(body)]).norm() < fastest)
        correct(body, least);
    keep_better();
  }
  /// Calls f(body, displacement per time) for the bodies that are displaced.
  template <class F>
  void each(F&& f) const {
    for (const std::int32_t body : order_) f(at(body), moved_[at(body)]);
  }

 private:
  static constexpr int most_rounds = 6;
  /// Damps as least_shift does: a round then moves a body at most some hundred times as far as its
  /// rates ask for, in the directions that supports almost leave free.
  static constexpr real damping = 1e-5;

  /// The rate of separation in excess of the one that is asked for.
  [[nodiscard]] real excess(const support& c) const {
    const vec3 own = of_point(moved_[at(c.body)], arm(c));
    const vec3 below = c.below >= 0 ? of_point(moved_[at(c.below)], arm_below(c)) : vec3(0, 0, 0);
    return c.sign * contact(c).axes.row(0).dot(own - below) - contact(c).correction_rate;
  }
  /// Whether no support needs the body to move further. Counts those that it comes too close to
  /// among the ones that hold it.
  bool settled(std::int32_t body, real least) {
    bool all = true;
    for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
      support& c = supports_[k];
      const real rate = excess(c);
      if (rate < -least) c.open = false;
      if (!c.open && std::abs(rate) > least) all = false;
    }
    return all;
  }
  void correct(std::int32_t body, real least) {
    const real length = length_of(body);
    for (int round = 0; round < most_rounds && !settled(body, least); ++round) {
      body_block g;
      body_vector change{};
      for (std::size_t k = first_[at(body)]; k < first_[at(body) + 1]; ++k) {
        const support& c = supports_[k];
        if (c.open) continue;
        const body_vector d = direction(c, 0, length);
        add_square(g, d);
        const real rate = excess(c);
        for (std::size_t j = 0; j < 6; ++j) change[j] -= rate * d[j];
      }
      if (!factorize(pivot_, g, damping)) return;
      pivot_.template solve<1>(change.data());
      moved_[at(body)].v += vec3(change[0], change[1], change[2]);
      if (at(body) >= s_->first_tensor)
        moved_[at(body)].w += 1 / length * vec3(change[3], change[4], change[5]);
    }
  }

  [[nodiscard]] static bool is_loaded(const island_contact& c) {
    return c.target_velocity == 0 && c.impulse.dot(c.axes.row(0)) > 0;
  }
  /// What is missing at a contact from its rate: a loaded one is to move as asked, the others may
  /// not come closer than that.
  [[nodiscard]] static real missing(const island_contact& c, real rate) {
    const real more = rate - c.correction_rate;
    return is_loaded(c) ? more : std::min(real(0), more);
  }
  /// Leaves the islands where they are whose contacts have not come closer to their rates.
  void keep_better() {
    disjoint_sets islands(moved_.size());
    for (const island_contact& c : *contacts_)
      if (moves(c.a) && moves(c.b)) islands.join(c.a, c.b);
    plain_vector<real> gained(moved_.size(), 0);
    for (const island_contact& c : *contacts_) {
      vec3 v{0, 0, 0};
      if (moves(c.a)) v += of_point(moved_[at(c.a)], c.arm_a);
      if (moves(c.b)) v -= of_point(moved_[at(c.b)], c.arm_b);
      const real before = missing(c, 0), after = missing(c, c.axes.row(0).dot(v));
      gained[islands.root(moves(c.a) ? c.a : c.b)] += before * before - after * after;
    }
    for (std::size_t i = 0; i < moved_.size(); ++i)
      if (!(gained[islands.root(i)] > 0)) moved_[i] = {};
  }

  plain_vector<body_motion> moved_;
  body_pivot pivot_;
};

/// Moves the bodies of stacks, if their contacts are far enough from where they should be; sweeps
/// of the correction follow. Nothing happens if contacts with other ranks exist.
template <class State>
void correct_stacks_here(std::span<const contact_access<State>> lists, State& s) {
  for (const contact_access<State>& list : lists)
    if (list.size(contact_part::boundary) > 0) return;
  // Fractions of what gravity adds in a step.
  constexpr real relevant = 1e-3, slow = 10, least = 1e-9;
  real most = 0;
  for (const contact_access<State>& list : lists) most = std::max(most, list.largest_correction());
  if (most < relevant * s.speed) return;
  std::size_t count = 0;
  for (const contact_access<State>& list : lists) count += list.size(contact_part::interior);
  plain_vector<island_contact> contacts;
  contacts.reserve(count);
  for (const contact_access<State>& list : lists)
    for (std::size_t i = 0, n = list.size(contact_part::interior); i < n; ++i)
      contacts.push_back(list.contact(contact_part::interior, i));
  plain_vector<std::int32_t> numbers(s.bodies.size(), -1);
  const isolated_island all(std::move(contacts), s, numbers);
  support_correction correction(all.contacts, all.state);
  if (!correction.stands()) return;
  correction.solve(slow * s.speed, least * s.speed);
  correction.each([&](std::size_t number, const body_motion& moved) {
    const std::uint32_t body = all.bodies[number];
    s.shift[body].v += in_scalar<typename State::number>(moved.v);
    if (body >= s.first_tensor) s.turn[body - s.first_tensor].w += moved.w;
  });
}

}  // namespace talus::detail
