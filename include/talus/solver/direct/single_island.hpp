#pragma once
// One island as a problem of its own, in the order of ids.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/direct/band_system.hpp"
#include "talus/solver/direct/body_newton.hpp"
#include "talus/solver/direct/body_problem.hpp"
#include "talus/solver/direct/clusters.hpp"
#include "talus/solver/direct/island_problem.hpp"
#include "talus/solver/direct/island_solver.hpp"
#include "talus/solver/direct/solve_bodies.hpp"
#include "talus/solver/direct/stalled_figures.hpp"
#include "talus/solver/direct/support_balance.hpp"

namespace talus::detail {

struct island_body {
  system_id id;
  solver_body state;
  bool has_tensor = false;
  mat3 tensor = mat3::Zero();
};
/// A contact; its bodies follow from its key, except those that cannot move.
struct keyed_contact {
  contact_key key;
  island_contact contact;
  bool a_moves = false, b_moves = false;
};

/// The bodies and contacts of all parts of an island; each contact comes from the rank of its body
/// a.
class single_island {
 public:
  /// Adds a part; see exact_islands.
  void add(const byte_buffer& bytes) {
    byte_reader in(bytes);
    for (auto count = in.get<std::size_t>(); count > 0; --count)
      bodies_.push_back(in.get<island_body>());
    while (!in.empty()) contacts_.push_back(in.get<keyed_contact>());
  }
  /// Solves it, if sweeps stall and a solution costs less than the sweeps that it replaces; returns
  /// whether its impulses are better than theirs. `fall` is the gain of velocity by gravity in a
  /// step.
  [[nodiscard]] bool solve(const vec3& fall, stalled_figures figures, real precision,
                           const island_limits& limits) {
    arrange(fall);
    const contact_order order(problem_, state_);
    const real row = 1 + static_cast<real>(order.length()), speed = fall.norm();
    figures.overloaded = figures.overloaded && is_overloaded();
    if (!figures.overloaded &&
        (problem_.size() > limits.many || !figures.is_narrow(row) || flows(speed)))
      return false;
    if (!figures.stalls(row, speed, precision)) return false;
    const auto n = static_cast<real>(problem_.size());
    double budget = std::min(most_operations, sweep_cost * figures.sweeps(row) * n);
    const real cost = band_system::cost(problem_.size(), order.half_bandwidth());
    if (cost <= std::min(few, budget / 2)) return solve_by_contacts(order, budget / cost);
    if (budget >= overhead * n && balances(speed)) return set_velocities(), true;
    if (!figures.overloaded || budget < body_newton::per_contact * n) return false;
    contact_vector r;
    const body_problem p(problem_, state_, r);
    const island_outcome result = solve_by_bodies(p, r, budget);
    if (!(result.after < result.before)) return false;
    impulses_.clear();
    for (std::size_t k = 0; k < problem_.size(); ++k)
      impulses_.push_back(problem_[k].axes.transpose() * r(static_cast<int>(k)));
    return set_velocities(), true;
  }
  /// The impulse of a contact; null if it is not one of the island.
  [[nodiscard]] const vec3* find_impulse(const contact_key& key) const {
    const auto at =
        std::lower_bound(contacts_.begin(), contacts_.end(), keyed_contact{key, {}}, by_key{});
    if (at == contacts_.end() || at->key != key) return nullptr;
    return &impulses_[static_cast<std::size_t>(at - contacts_.begin())];
  }
  [[nodiscard]] const solver_body& body(system_id id) const { return state_.bodies[place_of(id)]; }

 private:
  static constexpr double most_operations = 4e9;  ///< for an island in a step
  static constexpr real sweep_cost = 600;         ///< operations for each contact
  static constexpr real overhead = 2000;          ///< of a balance, for each contact
  static constexpr real few = 4e6;                ///< cheaper ones are solved by contacts

  struct by_key {
    bool operator()(const keyed_contact& x, const keyed_contact& y) const {
      const contact_key &a = x.key, &b = y.key;
      return std::tuple(a.a, a.b, a.feature) < std::tuple(b.a, b.b, b.feature);
    }
  };
  /// Bodies with scalar inertia come first.
  struct by_id {
    bool operator()(const island_body& x, const island_body& y) const {
      return std::tuple(x.has_tensor, x.id) < std::tuple(y.has_tensor, y.id);
    }
  };
  [[nodiscard]] std::size_t place_of(system_id id) const {
    for (const bool tensor : {false, true}) {
      const auto at =
          std::lower_bound(bodies_.begin(), bodies_.end(),
                           island_body{.id = id, .state = {}, .has_tensor = tensor}, by_id{});
      if (at != bodies_.end() && at->id == id)
        return static_cast<std::size_t>(at - bodies_.begin());
    }
    fail<std::logic_error>("a contact of an island has a body that no rank has sent");
  }
  void arrange(const vec3& fall) {
    sort_values(bodies_, by_id{}), sort_values(contacts_, by_key{});
    state_.fall = fall;
    for (const island_body& b : bodies_) {
      state_.bodies.push_back(b.state);
      if (b.has_tensor)
        state_.tensors.push_back(b.tensor);
      else
        ++state_.first_tensor;
    }
    const auto immovable = static_cast<std::int32_t>(state_.bodies.size());
    state_.bodies.push_back({}), state_.tensors.push_back(mat3::Zero());
    for (const keyed_contact& one : contacts_) {
      island_contact c = one.contact;
      c.a = one.a_moves ? static_cast<std::int32_t>(place_of(one.key.a)) : immovable;
      c.b = one.b_moves ? static_cast<std::int32_t>(place_of(one.key.b)) : -1;
      problem_.push_back(c);
    }
  }
  [[nodiscard]] bool is_overloaded() const {
    plain_vector<contact_ends> ends;
    plain_vector<real> masses;
    for (const island_contact& c : problem_) ends.push_back({c.a, c.b});
    for (const solver_body& b : state_.bodies)
      masses.push_back(b.inverse_mass != 0 ? 1 / b.inverse_mass : 0);
    overloaded_clusters clusters;
    clusters.find(
        ends, [](std::size_t) { return true; }, masses);
    return clusters.found();
  }
  bool solve_by_contacts(const contact_order& order, double systems) {
    plain_vector<island_contact> chain;
    for (const auto i : order.order()) chain.push_back(problem_[i]);
    contact_vector r;
    const assembled_problem p = assemble_island(chain, state_, r);
    solve_island(p, r, static_cast<int>(std::min(60., systems)));
    impulses_.resize(problem_.size());
    for (std::size_t k = 0; k < chain.size(); ++k)
      impulses_[order.order()[k]] = chain[k].axes.transpose() * r(static_cast<int>(k));
    return set_velocities(), true;
  }
  /// Whether more than an eighth of the loaded contacts slide or part, as in a heap that moves.
  [[nodiscard]] bool flows(real speed) const {
    const auto at_point = [&](std::int32_t body, const vec3& arm) -> vec3 {
      if (body < 0) return {0, 0, 0};
      const solver_body& b = state_.bodies[static_cast<std::size_t>(body)];
      return b.v + b.w.cross(arm);
    };
    std::size_t loaded = 0, fast = 0;
    for (const island_contact& c : problem_) {
      if (c.impulse == vec3(0, 0, 0)) continue;
      ++loaded;
      const vec3 v = at_point(c.a, c.arm_a) - at_point(c.b, c.arm_b);
      if (v.squaredNorm() > speed * speed) ++fast;
    }
    return fast > loaded / 8;
  }
  bool balances(real speed) {
    support_balance balance(problem_, state_);
    constexpr real exact = 1e-9;
    if (!(balance.solve(1e-10 * speed, 10 * speed, true) <= exact)) return false;
    impulses_.clear();
    for (std::size_t k = 0; k < problem_.size(); ++k)
      impulses_.push_back(balance.changes(k) ? balance.impulse(k) : problem_[k].impulse);
    return true;
  }
  /// Sets the velocities after the change of the impulses.
  void set_velocities() {
    const auto apply = [&](std::int32_t body, const vec3& arm, const vec3& impulse) {
      if (body < 0) return;
      const auto i = static_cast<std::size_t>(body);
      solver_body& b = state_.bodies[i];
      b.v += b.inverse_mass * impulse;
      if (i < state_.first_tensor)
        b.w += b.inverse_inertia * arm.cross(impulse);
      else
        b.w += state_.tensor(i) * arm.cross(impulse);
    };
    for (std::size_t k = 0; k < problem_.size(); ++k) {
      const island_contact& c = problem_[k];
      const vec3 change = impulses_[k] - c.impulse;
      apply(c.a, c.arm_a, change), apply(c.b, c.arm_b, -change);
    }
  }

  plain_vector<island_body> bodies_;
  plain_vector<keyed_contact> contacts_;
  solver_state state_;
  plain_vector<island_contact> problem_;
  plain_vector<vec3> impulses_;
};

}  // namespace talus::detail
