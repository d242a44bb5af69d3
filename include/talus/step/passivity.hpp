#pragma once
// Keeps the impulses of a step from adding energy, however incomplete the solution.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <type_traits>

#include "talus/constraint/contact_work.hpp"
#include "talus/constraint/impulse_scale.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/detect/time_of_impact.hpp"
#include "talus/solver/usual_kinds.hpp"
#include "talus/state/solved_velocity.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// The angular impulse that changes the angular velocity of body i by dw. `rotated`: if the solver
/// rotates it.
template <class Store>
[[nodiscard]] vec3 angular_impulse(const Store& store, std::size_t i, real mass, const vec3& dw,
                                   const rotated_body* rotated = nullptr) {
  const vec3 inertia = mass * store.shape[i].inertia();
  if constexpr (Store::tensor) {
    if (rotated != nullptr) return mass * rotated->momentum(dw);
    const quat& q = store.orientation_of[i];
    return q * vec3(inertia.cwiseProduct(q.conjugate() * dw));
  } else {
    return inertia[0] * dw;
  }
}

/// A body that takes part in contacts adds m v'^2/2 - m v^2/2 to the energy, of which its contact
/// impulse p = m (v' - v) - m g dt adds p (v + v')/2. The sum over the bodies is the work of all
/// contacts. It is at most 0 in an exact solution with one coefficient of restitution. It can be
/// positive if iterations are truncated after a warm start, and if several coefficients or friction
/// meet in one impact. Then the impulses are scaled by the largest common factor below 1 that makes
/// the work 0. A scaled impulse stays in its friction cone, and momentum is conserved. For resting
/// bodies that factor is also the best one: it minimises the energy that the impulses are to
/// minimise.
///
/// The factor belongs to an island of contacts of this rank. Both ranks of a boundary contact
/// compute the power that it transfers from the last velocities that both hold, so that the works
/// of the ranks add up to that of all contacts without a message. Each rank scales its interior
/// contacts, and leaves its boundary contacts as they are. Islands of joints without contacts, and
/// those with joints across ranks, are left as they are.
template <class Scenario, class Ranks>
class passivity {
  using state_type = world_state<Scenario>;
  using number = solved_scalar<Scenario>;
  static constexpr bool alone = state_type::link_type::alone;
  static constexpr bool by_colours = Ranks::coloured;
  static constexpr int most_plastic_sweeps = 50;
  static constexpr std::size_t few_solutions = 50'000;  ///< of contacts, which take no time
  static constexpr bool always = true;
  static constexpr bool divided = uses_substeps<typename Scenario::solver>;

 public:
  passivity(state_type& s, Ranks& ranks) : s_(s), ranks_(ranks), solver_(s.solver) {}

  /// After the solver, before the impulses are stored for the next step.
  void keep() {
    if constexpr (state_type::drives)
      if (s_.driving.moves) return;  // driven bodies may add unlimited energy
    if constexpr (by_colours) {
      if (!presses(s_)) keep_everywhere();  // other steps are not collective
    } else {
      if constexpr (!alone)
        if (!s_.on_one_rank()) meet_boundary();
      find_excess();
      shrink_interior();
      if constexpr (!alone)
        if (!s_.on_one_rank()) sweep_while_it_helps();
    }
  }

 private:
  /// Calls f(list) for the lists of contacts of the solver in use.
  template <class F>
  void each_list(F&& f) {
    auto&& lists = solver_lists<by_colours>(s_);
    each_of(lists, f);
  }
  /// Calls f(work, index in the solver's arrays) for each body owned here that can move, while
  /// `more`.
  template <class F>
  void each_body(F&& f, const bool& more = always) {
    s_.each_finite_shape([&](const auto& b) {
      const auto& store = b.movable;
      using store_type = std::remove_cvref_t<decltype(store)>;
      for (std::size_t i = 0; more && i < store.size(); ++i) {
        const std::size_t k = b.first + i;
        if (i >= store.locals && solver_.bodies[k].inverse_mass != 0) continue;
        if (solver_.bodies[k].inverse_mass == 0) {
          walls_ = walls_ || store.velocity[i] != vec3(0, 0, 0) ||
                   store.angular_velocity[i] != vec3(0, 0, 0);
          continue;
        }
        const vec3& before = store.velocity[i];
        const vec3 v = solved_velocity(s_, store, i, k), dv = v - free_velocity(s_, store, i);
        const vec3 w = solved_spin(s_, store, i, k);
        vec3 dw = w - free_spin(s_, store, i, k);
        const real mass = 1 / store.inverse_mass[i];
        impulse_work of;
        const vec3 mean = real(0.5) * (before + v) + offset_of(store, i, k);
        vec3 mean_w = real(0.5) * (store.angular_velocity[i] + w);
        vec3 spin = angular_impulse(store, i, mass, dw);
        real angular = spin.dot(mean_w);
        const rotated_body* rotated = nullptr;
        if constexpr (divided && store_type::tensor)
          if ((rotated = solver_.rotated_at(k)) != nullptr) {
            // In the course of the step, and changes since.
            const vec3 since = rotated->momentum(w - rotated->spin);
            spin = mass * (rotated->angular_impulse + since);
            angular = mass * (rotated->work + since.dot(real(0.5) * (rotated->spin + w)));
            dw = solver_.tensor(k) * spin;
            mean_w = w - real(0.5) * (solver_.gain[k].w + dw);
          }
        const real linear = mass * dv.dot(mean);
        of.work = linear + angular;
        const vec3 pull = v - dv - before;  // by gravity and forces
        of.rise = rise_of(mass * pull, before - v, k);
        // Impulses are differences of velocities, which have the round-off of those.
        constexpr real part = 1.0 / 16;
        of.size = std::abs(linear) + std::abs(angular) + mass * dv.squaredNorm() +
                  std::abs(spin.dot(dw)) + part * mass * mean.squaredNorm();
        vec3 own_dv = dv, own_dw = dw, own_spin = spin;  // by impulses that this rank may scale
        if constexpr (!alone && !by_colours)
          if (const auto& received = s_.passive.received; !received.empty()) {
            own_dv -= received[k].v, own_dw -= received[k].w;
            own_spin = angular_impulse(store, i, mass, own_dw, rotated);
            if (received[k].v != vec3(0, 0, 0)) of.fall = real(0.5) * mass * pull.dot(dv);
          }
        of.square = mass * own_dv.squaredNorm() + own_spin.dot(own_dw);
        if constexpr (!state_type::midpoint)  // the mean velocity over substeps stays
          of.rise_slope = real(divided ? 0.5 : -0.5) * mass * pull.dot(own_dv);
        // The mean velocity changes by half of the change of the impulses, and the work by both.
        of.slope = mass * own_dv.dot(mean + real(0.5) * dv) + own_spin.dot(mean_w + real(0.5) * dw);
        f(of, k);
      }
    });
  }
  /// The potential energy changes with the velocity that moves the body: the last one, but the mean
  /// one in the midpoint of a step, and that of the substeps of a step with substeps.
  [[nodiscard]] real rise_of(const vec3& pull, const vec3& slowed, std::size_t k) const {
    if constexpr (state_type::midpoint) return 0;
    real rise = real(0.5) * pull.dot(slowed);
    if constexpr (divided) rise -= pull.dot(solver_.drift[k].v);
    return (void)k, rise;
  }
  /// A body that is followed to its impact meets it with the velocity there.
  template <class Store>
  [[nodiscard]] vec3 offset_of(const Store& store, std::size_t i, std::size_t k) const {
    if constexpr (state_type::continuous)
      if (const real t = s_.impacts.time[k]; t != never)
        return (t - time_of_poses(s_)) * acceleration_of(s_, store, i);
    return (void)store, (void)i, (void)k, vec3(0, 0, 0);
  }

  /// Calls f(power, body) for contacts of bodies with prescribed velocity: they may add energy.
  template <class F>
  void subtract_walls(F&& f) {
    each_list([&](const auto& list) {
      list.each_acting([&](const auto& c, bool on_a, bool on_b) {
        using contact = std::remove_cvref_t<decltype(c)>;
        if constexpr (contact::paired) {
          const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(c.b);
          const auto &A = solver_.bodies[a], &B = solver_.bodies[b];
          if (A.inverse_mass == 0 && on_b) f(-work_on_a(c, v_of(A), w_of(A)), b);
          if (B.inverse_mass == 0 && on_a) f(-work_on_b(c, v_of(B), w_of(B)), a);
        }
      });
    });
  }

  /// The fraction that the impulses of each body's island must lose, if any island must.
  void find_excess() {
    auto& excess = s_.passive.excess;
    if constexpr (!alone) excess.assign(solver_.bodies.size(), 0);
    found_ = false;
    // An island that gains energy contains a body on which impulses do work, and one that gains
    // energy.
    bool worked = false, rose = false, unknown = true;
    each_body(
        [&](const impulse_work& w, std::size_t) {
          const real round_off = impulse_work::round_off(w.size);
          worked = worked || w.work > round_off;
          rose = rose || w.work + w.rise > round_off;
          unknown = !worked || !rose;
        },
        unknown);
    if (unknown) return;
    join_islands();
    add_up_islands();
    const auto& works = s_.passive.works;
    for (const impulse_work& w : works) found_ = found_ || w.adds_energy();
    if (!found_) return;
    plain_vector<real> of_islands(works.size());
    for (std::size_t k = 0; k < works.size(); ++k) of_islands[k] = works[k].excess();
    excess.resize(solver_.bodies.size());
    for (std::size_t k = 0; k < excess.size(); ++k) excess[k] = of_islands[s_.passive.island[k]];
  }
  [[nodiscard]] const impulse_work& island_of(std::size_t body) const {
    return s_.passive.works[s_.passive.island[body]];
  }
  void add_up_islands() {
    auto& works = s_.passive.works;
    works.assign(s_.passive.islands, {});
    const auto add = [&](const impulse_work& w, std::size_t k) {
      works[s_.passive.island[k]] += w;
    };
    each_body(add);
    each_exchange(add);
    // The solution of joints is exact. Their impulses alone are left as they are, and an island of
    // joints on several ranks, of which this rank sees a part.
    if constexpr (Ranks::solves_joints) {
      plain_vector<char> touched(works.size(), 0);
      const auto island = [&](std::int32_t k) {
        return s_.passive.island[static_cast<std::size_t>(k)];
      };
      each_list([&](const auto& list) {
        using contact = typename std::remove_cvref_t<decltype(list)>::contact_type;
        if constexpr (!is_joint<contact>)
          list.each([&](const contact& c, bool) {
            if (!acts(c)) return;
            if (moves(c.a)) touched[island(c.a)] = 1;
            if constexpr (contact::paired)
              if (moves(c.b)) touched[island(c.b)] = 1;
          });
      });
      for (const joint_partner& p : s_.joints.partners)
        for (const std::uint32_t k : p.sent)
          if (const joint_end& end = s_.joints.ends[k]; end.own && end.moves)
            touched[island(end.number)] = 0;
      for (std::size_t k = 0; k < works.size(); ++k)
        if (!touched[k]) works[k] = {};
    }
  }
  void join_islands() {
    auto& root = s_.passive.root;
    root.resize(solver_.bodies.size());
    std::iota(root.begin(), root.end(), std::uint32_t{0});
    const auto find = [&](std::size_t i) {
      auto k = static_cast<std::uint32_t>(i);
      while (root[k] != k) k = root[k] = root[root[k]];
      return k;
    };
    const auto join = [&](std::int32_t one, std::int32_t other) {
      if (one >= 0 && other >= 0 &&
          root[static_cast<std::size_t>(one)] == root[static_cast<std::size_t>(other)])
        return;
      if (!moves(one) || !moves(other)) return;
      const auto a = find(static_cast<std::size_t>(one)), b = find(static_cast<std::size_t>(other));
      root[std::max(a, b)] = std::min(a, b);
    };
    each_list([&](const auto& list) {
      if constexpr (requires { list.each_loaded_pair(join); })
        list.each_loaded_pair(join);
      else
        list.each_interior_contact([&](const auto& c) {
          if constexpr (std::remove_cvref_t<decltype(c)>::paired)
            if (acts(c)) join(c.a, c.b);
        });
    });
    auto& island = s_.passive.island;
    island.resize(root.size());
    s_.passive.islands = 0;
    for (std::size_t k = 0; k < root.size(); ++k)  // the first body of an island is its root
      island[k] = root[k] == k ? s_.passive.islands++ : island[root[k]];
  }
  template <class Constraint>
  [[nodiscard]] static bool acts(const Constraint& c) {
    if constexpr (is_joint<Constraint>)
      return c.impulse_in_frame().squaredNorm() > 0;
    else
      return c.impulse().squaredNorm() > 0;
  }
  [[nodiscard]] bool moves(std::int32_t i) const {
    return i >= 0 && solver_.bodies[static_cast<std::size_t>(i)].inverse_mass != 0;
  }
  void shrink_interior() {
    if (!found_) return;
    const auto& excess = s_.passive.excess;
    each_list([&](auto& list) {
      const auto excess_of = [&](std::int32_t a, std::int32_t b) {
        return excess[static_cast<std::size_t>(moves(a) ? a : b)];
      };
      list.edit_interior_contacts(
          [&](std::int32_t a, std::int32_t b) { return excess_of(a, b) != 0; },
          [&](auto& c) {
            shrink(c, excess_of(c.a, c.b), [&](const auto& change) { c.apply(solver_, change); });
          });
    });
  }
  /// Sweeps again where islands gain too much energy from boundary contacts. Interior contacts
  /// cannot take up all gains: those of a body without interior contacts, none. Large islands get
  /// at most half as many sweeps as the solver makes.
  void sweep_while_it_helps() {
    real last = std::numeric_limits<real>::infinity();
    std::size_t left = 0;
    each_list([&](const auto& list) { left += list.size(); });
    left = std::max(left * static_cast<std::size_t>(s_.settings.iterations) / 2, few_solutions);
    for (int k = 0; found_ && k < most_plastic_sweeps; ++k) {
      add_up_islands();
      real gained = 0;
      for (const impulse_work& w : s_.passive.works)
        if (w.adds_energy()) gained += std::min(w.work, w.work + w.rise);
      found_ = gained > 0 && gained < real(1 - 1e-3) * last;
      last = gained;
      if (!found_) return;
      const std::size_t solved = sweep_plastically();
      found_ = solved > 0 && solved < left;
      left -= std::min(left, solved);
    }
  }
  /// Solves each interior contact as a plastic one, which dissipates energy, in islands that gain
  /// energy. Returns their number.
  std::size_t sweep_plastically() {
    std::size_t solved = 0;
    each_list([&](auto& list) {
      const auto gains = [&](std::int32_t body) {
        return moves(body) && island_of(static_cast<std::size_t>(body)).adds_energy();
      };
      list.edit_interior_contacts(
          [&](std::int32_t a, std::int32_t b) { return gains(a) || gains(b); },
          [&](auto& c) {
            ++solved;
            if constexpr (is_joint<decltype(c)>) {
              c.apply(solver_, c.relax(solver_));
            } else {
              const auto target = c.target_velocity;
              c.target_velocity = std::min(c.target_velocity, decltype(c.target_velocity)(0));
              c.prepare(solver_, 1, 1);
              const auto change = c.relax(solver_);
              c.target_velocity = target;
              c.apply(solver_, change);
            }
          });
    });
    return solved;
  }
  /// Calls f(joint) for the joints that count here.
  template <class F>
  void each_joint(F&& f) {
    if constexpr (state_type::has_joints)
      each_list([&](const auto& list) {
        if constexpr (is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>)
          list.each([&](const auto& c, bool counts_here) {
            if (counts_here) f(c);
          });
      });
  }
  /// Calls f(work, body) for contacts with bodies of another rank or of prescribed velocity, and
  /// for the drives of joints.
  template <class F>
  void each_exchange(F&& f) {
    each_joint([&](const auto& c) {
      const real work = c.driven_work(solver_);
      f({.work = -work, .slope = -work}, static_cast<std::size_t>(moves(c.a) ? c.a : c.b));
    });
    if (walls_)
      subtract_walls(
          [&](real power, std::size_t body) { f({.work = -power, .slope = -power}, body); });
    if constexpr (!alone && !by_colours)
      if (boundary_)
        each_boundary([&](auto& c, bool owns_a) {
          const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(c.b);
          const auto& p = s_.passive;
          const vec3 q = impulse_on_a(c);
          const auto power = [&](const auto& of) {
            if constexpr (is_joint<decltype(c)>)
              return work_on_a(c, of[a].v, of[a].w) - work_on_b(c, of[b].v, of[b].w);
            else
              return q.dot(velocity_on_a(c, of[a].v, of[a].w) + velocity_on_b(c, of[b].v, of[b].w));
          };
          const real carried = real(0.25) * (power(p.earlier) + power(held(owns_a ? b : a)));
          f({.work = owns_a ? -carried : carried, .shared = q != vec3(0, 0, 0)}, owns_a ? a : b);
        });
  }
  /// Removes the fraction d of the impulse of a contact, and applies the change. Positions follow
  /// the mean velocity over substeps, which stays.
  template <class Contact, class Apply>
  void shrink(Contact& c, real d, Apply&& apply) {
    const auto before = c.impulse_in_frame();
    c.set(static_cast<number>(1 - d) * before);
    const auto change = c.since(before);
    if constexpr (divided) {
      const auto a = static_cast<std::size_t>(c.a);
      keep_drift(a, real{1});
      if constexpr (Contact::paired) keep_drift(static_cast<std::size_t>(c.b), real{1});
      apply(change);
      keep_drift(a, real{-1});
      if constexpr (Contact::paired) keep_drift(static_cast<std::size_t>(c.b), real{-1});
    } else {
      apply(change);
    }
  }
  void keep_drift(std::size_t body, real sign) {
    solver_.drift[body].v += sign * solver_.bodies[body].v;
    solver_.drift[body].w += sign * solver_.bodies[body].w;
  }

  // Across ranks.

  template <class F>
  void each_boundary(F&& f) {
    each_list([&](auto& list) {
      list.edit_boundary_contacts([&](auto& c, bool owns_a) {
        if constexpr (std::remove_cvref_t<decltype(c)>::paired) f(c, owns_a);
      });
    });
  }
  /// The last velocities that this rank and the owner of a copy both hold.
  [[nodiscard]] const plain_vector<body_motion>& held(std::size_t copy) const {
    const auto& p = s_.passive;
    return p.refreshed.empty() || p.refreshed[copy] ? p.common : p.common_before;
  }
  /// The impulses of boundary contacts on own bodies, and the velocities before the step.
  void meet_boundary() {
    auto& p = s_.passive;
    p.received.clear();
    each_list([&](const auto& list) { boundary_ = boundary_ || list.has_boundary(); });
    if (!boundary_) return;
    p.earlier.resize(solver_.bodies.size());
    s_.each_finite_shape([&](const auto& b) {
      for (std::size_t i = 0; i < b.movable.size(); ++i) {
        const std::size_t k = b.first + i;
        p.earlier[k] = {b.movable.velocity[i], b.movable.angular_velocity[i]};
      }
    });
    p.received.assign(solver_.bodies.size(), {});
    each_boundary([&](auto& c, bool owns_a) {
      const auto own = static_cast<std::size_t>(owns_a ? c.a : c.b);
      if constexpr (is_joint<decltype(c)>) {
        const wrench x = owns_a ? c.on_a() : c.on_b();
        p.received[own].v += real(solver_.bodies[own].inverse_mass) * x.impulse;
        p.received[own].w += spin_by(own, x.moment);
      } else {
        const vec3 q = (owns_a ? 1 : -1) * impulse_on_a(c);
        p.received[own].v += real(solver_.bodies[own].inverse_mass) * q;
        p.received[own].w += spin_by(own, (owns_a ? c.lever_a() : c.lever_b()).cross(q));
      }
    });
  }
  [[nodiscard]] vec3 spin_by(std::size_t k, const vec3& twist) const {
    if (k >= solver_.first_tensor && k - solver_.first_tensor < solver_.tensors.size())
      return solver_.tensor(k) * twist;
    return real(solver_.bodies[k].inverse_inertia) * twist;
  }

  /// Whether the island of a body has an acting contact, on however many ranks it lies. (The
  /// solution of joints is exact: their impulses alone are left as they are.) Ranks propagate this
  /// through their copies until none changes.
  void find_touched() {
    touched_.assign(solver_.bodies.size(), real(!Ranks::solves_joints));
    if constexpr (Ranks::solves_joints) {
      disjoint_sets islands(touched_.size());
      each_list([&](const auto& list) {
        list.each([&](const auto& c, bool) {
          using constraint = std::remove_cvref_t<decltype(c)>;
          if (!acts(c)) return;
          if (!is_joint<constraint>) touched_[mover_of(c)] = 1;
          if constexpr (constraint::paired)
            if (moves(c.a) && moves(c.b)) islands.join(c.a, c.b);
        });
      });
      for (double more = 1; more > 0;) {
        plain_vector<real> of_island(touched_.size(), 0);
        for (std::size_t k = 0; k < touched_.size(); ++k)
          of_island[islands.root(k)] = std::max(of_island[islands.root(k)], touched_[k]);
        for (std::size_t k = 0; k < touched_.size(); ++k) touched_[k] = of_island[islands.root(k)];
        more = 0;
        if constexpr (!alone) {
          const plain_vector<real> before = touched_;
          ranks_.share_values(touched_);
          for (std::size_t k = 0; k < touched_.size(); ++k) {
            if (touched_[k] > before[k]) more = 1;
            touched_[k] = std::max(touched_[k], before[k]);
          }
          s_.link->reduce(reduction::max, std::span(&more, 1));
        }
      }
    }
  }
  template <class Constraint>
  [[nodiscard]] std::size_t mover_of(const Constraint& c) const {
    if constexpr (Constraint::paired) return static_cast<std::size_t>(moves(c.a) ? c.a : c.b);
    return static_cast<std::size_t>(c.a);
  }

  /// If nothing may depend on the ranks: one factor for all impulses of islands with contacts, from
  /// exact sums.
  void keep_everywhere() {
    find_touched();
    std::array<signed_sum, 3> sums;  // work, slope, square
    const auto add = [&](std::size_t at, real x) { sums[at] += x; };
    each_body([&](const impulse_work& w, std::size_t k) {
      if (touched_[k] == 0) return;
      add(0, w.work), add(1, w.slope), add(2, w.square);
    });
    if (walls_) subtract_walls([&](real power, std::size_t) { add(0, -power), add(1, -power); });
    each_joint([&](const auto& c) {
      if (touched_[mover_of(c)] == 0) return;
      const real work = c.driven_work(solver_);
      add(0, -work), add(1, -work);
    });
    if constexpr (!alone) ranks_.sum_exactly(sums);
    const impulse_work all{.work = sums[0].value(),
                           .slope = sums[1].value(),
                           .square = sums[2].value(),
                           .size = sums[0].plus.value() + sums[0].minus.value()};
    const real d = all.excess();
    if (d == 0) return;
    each_list([&](auto& list) {
      list.edit_all([&](auto& c) {
        if (touched_[mover_of(c)] != 0) c.set(static_cast<number>(1 - d) * c.impulse_in_frame());
      });
    });
    s_.each_finite_shape([&](const auto& b) {
      for (std::size_t i = 0; i < b.movable.locals; ++i) {
        const std::size_t k = b.first + i;
        if (solver_.bodies[k].inverse_mass == 0 || touched_[k] == 0) continue;
        const vec3 v = free_velocity(s_, b.movable, i), w = free_spin(s_, b.movable, i, k);
        solver_.bodies[k].v = in_scalar<number>(vec3(v + (1 - d) * (v_of(solver_.bodies[k]) - v)));
        solver_.bodies[k].w = in_scalar<number>(vec3(w + (1 - d) * (w_of(solver_.bodies[k]) - w)));
      }
    });
  }

  state_type& s_;
  Ranks& ranks_;
  solver_state_of<number>& solver_;
  plain_vector<real> touched_;  ///< 1 or 0, of each body; see find_touched()
  bool walls_ = false;          ///< a body that contacts cannot move has a velocity
  bool boundary_ = false;       ///< there are boundary contacts
  bool found_ = false;          ///< an island adds energy
};

}  // namespace talus::detail
