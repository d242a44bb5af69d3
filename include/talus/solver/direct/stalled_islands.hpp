#pragma once
// Small groups of contacts on which sweeps stall (a heavy body on light ones, a tall stack) are
// solved as one problem.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "talus/constraint/solver_state.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/contact_access.hpp"
#include "talus/solver/direct/band_system.hpp"
#include "talus/solver/direct/body_problem.hpp"
#include "talus/solver/direct/island_problem.hpp"
#include "talus/solver/direct/island_solver.hpp"
#include "talus/solver/direct/isolated_island.hpp"
#include "talus/solver/direct/solve_bodies.hpp"
#include "talus/solver/direct/stalled_search.hpp"
#include "talus/solver/direct/support_balance.hpp"

namespace talus::detail {

/// Finds the islands (contacts connected through movable bodies) on which the last sweep still
/// changed more than it should, and solves those that are cheap to solve. The error that sweeps
/// leave grows with the ratio of the masses and the square of the bodies in a row: a stack of ten
/// with a top of a thousand times the density needs tens of thousands of sweeps, and one Newton
/// step; so does a plate on thousands of spheres. Contacts with bodies of other ranks keep their
/// impulses.
template <class State>
class stalled_islands {
  using access = contact_access<State>;
  using search = stalled_search<State>;
  using island = stalled_island;

 public:
  /// A sweep, and then the stalled islands. If all of them are too large to be solved here, as in a
  /// pile, the search is postponed for some steps. Returns whether more sweeps would change nothing
  /// of relevance. A `first` sweep ends with that if it is so with the islands of the last search.
  static bool sweep_and_solve(std::span<const access> lists, State& s, bool first) {
    if (s.speed == 0)  // no gravity
      for (const auto& b : s.bodies) s.speed = std::max(s.speed, 1e-3 * v_of(b).norm());
    // A smaller change is irrelevant, or is round-off.
    const real least = (std::is_same_v<typename State::number, real> ? 1e-9 : 1e-5) * s.speed;
    std::size_t stalled = 0, contacts = 0;
    real most = 0;
    plain_vector<std::span<const plain_pair<std::size_t, real>>> changes;
    for (const access& list : lists) {
      changes.emplace_back(list.sweep_watched(s, least));
      stalled += changes.back().size();
      contacts += list.size(contact_part::interior);
      for (const auto& [i, change] : changes.back()) most = std::max(most, change);
    }
    if (stalled == 0 && !first) s.islands.forget_errors();
    if (stalled == 0) return true;
    if (first && most * s.islands.errors_per_change() <= negligible * s.speed) return true;
    search found(lists, {changes.data(), changes.size()}, s);
    plain_vector<island>& islands = found.islands();
    plain_vector<plain_pair<real, std::size_t>> worst_first;
    for (const island& one : islands)
      worst_first.emplace_back(found.is_solved_here(one) ? -one.error() : 0, worst_first.size());
    sort_values(worst_first);
    double budget = s.islands.open(contacts);
    bool solved = false, searched_at = false;
    const bool looks_for_long = s.islands.looks_for_long();
    std::size_t looked_at = 0, long_ones = 0;
    for (const bool clusters : {false, true})  // not of islands that are solved as a whole
      for (const auto& [stall, i] : worst_first) {
        island& one = islands[i];
        if (one.is_cluster() != clusters ||
            -stall <= (one.sweeps_do() ? negligible : left_to_sweeps(one)) * s.speed)
          continue;
        if (clusters && islands[one.within].done) continue;
        const bool looks = looks_for_long && one.may_be_long();
        if (!one.sweeps_do() && !one.overloaded && !looks && s.islands.spare() == 0) continue;
        searched_at |= !one.sweeps_do() && -stall > let_be * s.speed;
        one.done =
            one.sweeps_do() ? balance_large(one, found, s) : solve_one(one, found, s, budget);
        solved |= one.done && -stall > let_be * s.speed;
        looked_at += looks, long_ones += one.is_long;
        if (island& all = islands[clusters ? one.within : i]; all.size == one.size)
          all.done = one.done;
      }
    bool settled = true;
    real errors = 0;
    for (const island& one : islands) {
      errors =
          std::max(errors, one.error_per_change() * (is_few(one) ? negligible / left_to_few : 1));
      settled = settled && (one.done || one.error() <= left_when_settled(one) * s.speed);
    }
    s.islands.note_errors(errors);
    if (looked_at > 0) s.islands.note_long(long_ones > 0);
    s.islands.close(budget);
    if (!solved && !settled && (searched_at || stalled > island::many)) s.islands.pause();
    return settled;
  }

 private:
  /// Operations for each contact of a sweep; doubled, because a solution is exact.
  static constexpr real sweep_cost = 600;
  /// Operations for each contact of an attempt, besides linear systems. A balance that succeeds is
  /// not counted where more than `let_be` was left: it is always worth its cost.
  static constexpr real overhead = 2000;
  /// The fraction of an error that a solution may leave where Newton's method can find a better
  /// one.
  static constexpr real exact = 1e-9;
  /// Bodies that rest on each other move relative to each other by less than this multiple of it,
  /// which is above round-off.
  static constexpr real at_rest = 1e-10;
  /// Bodies that can rest on each other are not faster than this multiple of solver_state::speed.
  static constexpr real fast = 10;
  /// Rows through which the sweeps of the position correction do not carry.
  static constexpr int tall = 8;
  /// Cheaper islands are solved by contacts, which is as good for a few.
  static constexpr real few = 4e6;
  /// Operations for each contact that the solution of a few bodies at rest is worth.
  static constexpr real many_sweeps = 1e5;
  /// The fraction of solver_state::speed that may be left as error.
  static constexpr real let_be = 0.1;
  /// The fraction of solver_state::speed up to which an error needs no more sweeps, and no balance.
  static constexpr real negligible = 1e-4;

  /// In place of either for a single body on what cannot move. Its solution costs little, and what
  /// is left tilts it: on a seam between a fixed and a global body, whose contacts are in two
  /// lists.
  static constexpr real left_to_one = 1e-7;
  /// This is the limit for a few bodies at rest on each other: near the rim of what carries them,
  /// they tip by a multiple of it within a second.
  static constexpr real left_to_few = 1e-6;

  static bool is_single(const island& one) {
    return one.bodies == 1 && !one.jointed && std::is_same_v<typename State::number, real>;
  }
  /// A few bodies with faces on each other, whose points share a load.
  static bool is_few(const island& one) {
    return one.bodies <= island::few_bodies && one.size >= 3 * one.bodies && !one.jointed &&
           !one.is_cluster();
  }
  static real left_to_sweeps(const island& one) {
    return is_single(one) ? left_to_one : is_few(one) ? left_to_few : let_be;
  }
  static real left_when_settled(const island& one) {
    return is_single(one) ? left_to_one : one.rests ? left_to_few : negligible;
  }

  enum class outcome : char { not_stalled, failed, done };
  /// Lets the bodies of an island rest on each other, if so many are above each other that sweeps
  /// stall, and if they can.
  /// More than the fraction `left` of the error is a failure.
  static outcome balance(island& one, const isolated_island& alone, real left, const search& found,
                         State& s) {
    support_balance balance(alone.contacts, alone.state);
    one.rows = static_cast<real>(balance.rows());
    if (one.error() <= negligible * s.speed) return outcome::not_stalled;
    const bool solved = balance.solve(at_rest * s.speed, fast * s.speed, left == exact) <= left;
    if (balance.rows() >= tall) s.islands.note_stack(solved);
    if (!solved) return outcome::failed;
    s.islands.solved();
    const auto members = found.members_of(one);
    for (std::size_t k = 0; k < members.size(); ++k)
      if (balance.changes(k)) found.set(members[k], balance.impulse(k), s);
    return outcome::done;
  }
  /// Balances a large island, as balance() does. Further attempts are postponed unless it succeeds.
  static bool balance_large(island& one, search& found, State& s) {
    const outcome result = balance(one, found.isolate(one, s), 0.5, found, s);
    if (result == outcome::done) s.islands.balanced();
    if (result == outcome::failed) s.islands.not_balanced();
    if (result == outcome::not_stalled) s.islands.need_no_balance();
    return result == outcome::done;
  }
  /// Whether more than an eighth of the loaded contacts slide or part faster than `speed`, as in a
  /// heap that moves.
  static bool flows(const isolated_island& alone, real speed) {
    const auto at_point = [&](std::int32_t body, const vec3& arm) -> vec3 {
      if (body < 0) return {0, 0, 0};
      const solver_body& b = alone.state.bodies[static_cast<std::size_t>(body)];
      return b.v + b.w.cross(arm);
    };
    std::size_t loaded = 0, fast_ones = 0;
    for (const island_contact& c : alone.contacts) {
      if (c.impulse == vec3(0, 0, 0)) continue;
      ++loaded;
      const vec3 v = at_point(c.a, c.arm_a) - at_point(c.b, c.arm_b);
      if (v.squaredNorm() > speed * speed) ++fast_ones;
    }
    return fast_ones > loaded / 8;
  }
  /// Whether the island, with its known length, is stalled and within the budget.
  static bool solve_one(island& one, search& found, State& s, double& budget) {
    const isolated_island alone = found.isolate(one, s);
    const plain_vector<island_contact>& contacts = alone.contacts;
    const contact_order order(contacts, alone.state);
    const real rows = one.rows = 1 + static_cast<real>(order.length());
    const real error = one.error();
    if (error <= left_to_sweeps(one) * s.speed) return false;
    const real cost = band_system::cost(contacts.size(), order.half_bandwidth());
    const real sweeps = rows * rows * one.most_mass / one.least_mass;
    // A body whose load is near the rim of what carries it, as a box on a column, needs far more.
    const bool flowing = flows(alone, s.speed);
    one.rests = is_few(one) && !flowing;
    const bool rests = is_single(one) || one.rests;
    if (!rests && error <= let_be * s.speed) return false;
    // The joints move what was solved here, so that it stalls again.
    one.is_long = !one.is_cluster() && !one.jointed && one.is_narrow(rows) && !flowing;
    const bool fails = (one.is_long || (one.overloaded && !one.jointed)) &&
                       (is_single(one) || error > let_be * s.speed);
    // Not if the sweeps that it replaces cost less, as in wide heaps.
    const real least = is_single(one) ? std::numeric_limits<real>::infinity()
                       : rests        ? many_sweeps
                                      : 0;
    const real pays = std::max(sweep_cost * sweeps, least) * static_cast<real>(contacts.size());
    if (!fails && s.islands.spare() == 0) return false;
    if (!fails) s.islands.spend_spare(overhead * static_cast<real>(contacts.size()));
    double left = std::min<double>(fails ? budget : s.islands.spare(), pays);
    const double before = left;
    const auto spend = [&](double used) {
      if (fails)
        budget -= used;
      else
        s.islands.spend_spare(used);
    };
    const real most = rests ? island::many_points * static_cast<real>(contacts.size()) : few;
    if (cost <= std::min<real>(most, left / 2)) {
      solve_by_contacts(one, alone, order, cost, found, s, left);
      spend(before - left);
      s.islands.solved();
      return true;
    }
    if (s.fall != vec3(0, 0, 0) && balance(one, alone, exact, found, s) == outcome::done) {
      if (!fails && error > let_be * s.speed)
        s.islands.spend_spare(-overhead * static_cast<real>(contacts.size()));
      return true;
    }
    one.rows = rows;
    if (!one.is_small() && !one.is_cluster() && !one.is_long) return false;
    if (left < body_newton::per_contact * static_cast<real>(contacts.size())) return false;
    contact_vector r;
    const body_problem problem(contacts, alone.state, r);
    const island_outcome result = solve_by_bodies(problem, r, left);
    spend(before - left);
    if (fails && result.too_dear && !result.solved && pays > before)
      s.islands.skip(contacts.size());
    if (!(result.after < result.before)) return result.solved;
    s.islands.solved();
    const auto members = found.members_of(one);
    for (std::size_t k = 0; k < members.size(); ++k)
      found.set(members[k], contacts[k].axes.transpose() * r(static_cast<int>(k)), s);
    return result.after < 0.5 * result.before;
  }
  static void solve_by_contacts(const island& one, const isolated_island& alone,
                                const contact_order& order, real cost, const search& found,
                                State& s, double& budget) {
    plain_vector<island_contact> chain;
    for (const auto i : order.order()) chain.push_back(alone.contacts[i]);
    contact_vector r;
    const assembled_problem problem = assemble_island(chain, alone.state, r);
    budget -= cost * solve_island(problem, r, static_cast<int>(budget / cost));
    for (std::size_t k = 0; k < chain.size(); ++k)
      found.set(found.members_of(one)[order.order()[k]],
                chain[k].axes.transpose() * r(static_cast<int>(k)), s);
  }
};

}  // namespace talus::detail
