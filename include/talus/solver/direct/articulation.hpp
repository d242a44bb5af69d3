#pragma once
// Joints that movable bodies connect are solved together, exactly, with all other impulses held.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "talus/constraint/joint_line.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/added_energy.hpp"
#include "talus/solver/direct/articulated_rows.hpp"
#include "talus/solver/direct/articulated_system.hpp"
#include "talus/solver/direct/shared_loads.hpp"
#include "talus/solver/direct/supported_loads.hpp"

namespace talus::detail {

/// The search for the impulses of joints that movable bodies connect.
class articulation : private articulated_rows {
 public:
  void add(const joint_view& x) { joints.push_back(x); }

  /// Numbers the bodies, and finds the structure of the system. `number` holds -1 for all bodies,
  /// before and after.
  template <class Bodies>
  void arrange(const Bodies& all, plain_vector<std::int32_t>& number) {
    articulated_rows::arrange(all, number);
    system_.arrange(static_cast<std::int32_t>(bodies.size()), {ties.data(), ties.size()});
    held_.assign(rows, bound::none), start_.assign(rows, 0), residuals_.assign(rows, 0);
    factorized_ = false, care_ = care::none, softness_ = soft;
  }
  /// The rows are others from now on, and the factorization is an approximation.
  void renew() { stale_ = true; }

  /// Changes the impulses of the joints, and the motions of the bodies, so that all rows hold.
  template <class Bodies>
  void solve(Bodies& all) {
    bool bounded = false, rebounds = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      start_[first[j] + k] = r;
      if (!x.bounded()) return;
      bounded = true, rebounds = rebounds || is_rebound(j, x);
      if (factorized_) return;
      const real w = mobility(j, x);
      const real alone =
          w > 0 ? r + (x.target - rate(x, all, joints[j]) - x.compliance * r) / w : r;
      if (alone <= x.least) held_[first[j] + k] = bound::least;
      if (alone >= x.most) held_[first[j] + k] = bound::most;
    });
    note_motions(all), move_to_bounds(all);
    largest_push_ = 0;
    find(all, bounded);
    if (largest_push_ > far * speed_) {
      add_up(all), refine(all);
      if (bounded) move_within_bounds(all);
      add_up(all);
    }
    if (rebounds) damp_rebounds(all);
  }
  /// Rows that depend on each other share their loads.
  void share_loads() {
    bool any = false;
    if (factorized_)
      each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
        any = any || (shares_load(x, r) && mobility(j, x) > 0 && depends(j, k));
      });
    if (any) (void)shared_loads(*this, system_).find();
  }
  /// Whether contacts may make them depend on each other: several motors of given velocity.
  [[nodiscard]] bool may_need_supports() {
    int motors = 0;
    each_row([&](std::size_t, std::size_t, const joint_line& x, real& r) {
      motors += x.use == line_use::motor && shares_load(x, r);
    });
    return motors > 1;
  }
  /// Shares the loads among the rows, and the contacts of its bodies with what cannot move, which
  /// are sorted.
  template <class Bodies>
  void share_loads(const Bodies& all, std::span<joint_support> supports,
                   plain_vector<std::int32_t>& number) {
    if (!may_need_supports() || !supported_loads::find(*this, all, supports, number)) share_loads();
  }

 private:
  enum class bound : char { none, least, most };
  /// How rows are solved that nearly depend on others: exactly; as if they did, if the impulses or
  /// velocities would be far too large, and exactly after all if that is worse; and by least
  /// squares, if rows contradict each other.
  enum class care : char { none, more, in_vain, yields };
  /// Velocities on the way to a solution, over those of the solution, whose round-off counts.
  static constexpr real far = 1e3;
  /// The compliance of contradicting rows, over their mobility: at first, and at most.
  static constexpr real soft = 1e-6, softest = 1e-2;
  [[nodiscard]] real compliance_of(std::size_t j, const joint_line& x) const {
    return care_ == care::yields ? x.compliance + softness_ * mobility(j, x) : x.compliance;
  }
  /// A limit that is reached and has a coefficient of restitution. Where positions are solved there
  /// is none.
  [[nodiscard]] bool is_rebound(std::size_t j, const joint_line& x) const {
    return x.use == line_use::limits && x.target > 0 && joints[j].before != nullptr;
  }
  /// Not the positions, where gaps are targets.
  [[nodiscard]] bool solves_velocities() const {
    return !joints.empty() && joints.front().before != nullptr;
  }
  [[nodiscard]] real target_of(std::size_t j, const joint_line& x) const {
    return plastic_ && is_rebound(j, x) ? real(0) : x.target;
  }
  void factorize() {
    system_.clear();
    set_bodies(system_, 1);
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real&) {
      if (held_[first[j] + k] != bound::none) return;
      if (const real scale = mobility(j, x); scale > 0)
        set_row(system_, j, k, x, compliance_of(j, x), scale);
    });
    constexpr real exact = 1e-12, nearly = 1e-8;
    system_.factorize(care_ == care::more ? nearly : exact);
    factorized_ = true, stale_ = false;
  }
  [[nodiscard]] bool depends(std::size_t j, std::size_t k) const {
    return factorized_ && system_.depends(row_of(j, k));
  }
  [[nodiscard]] std::size_t row_of(std::size_t j, std::size_t k) const {
    return system_.of_joint(static_cast<std::int32_t>(j)) + k;
  }

  template <class Bodies>
  void find(Bodies& all, bool bounded) {
    constexpr int all_at_once = 8, rounds = 40, adding = 32;
    for (int round = 0; round < rounds; ++round) {
      refine(all);
      const bool more =
          (bounded && (round < adding ? change_bounds(all, round >= all_at_once) || meet_bound()
                                      : hold_beyond_bounds())) ||
          take_care(all);
      if (!more) break;
      start_again(all);
    }
    if (bounded) move_within_bounds(all);
  }
  /// Takes a solution between the one without rebounds and the present one: the last that adds no
  /// energy. Rebounds with several coefficients add some, and so do those of bodies whose joints
  /// have not held before.
  template <class Bodies>
  void damp_rebounds(Bodies& all) {
    const auto full = added_energy::of(*this, all);
    if (!full.any()) return;
    plain_vector<real> impulses;
    plain_vector<body_motion> motions;
    each_row([&](std::size_t, std::size_t, const joint_line&, real& r) { impulses.push_back(r); });
    for (const std::int32_t i : bodies) motions.push_back(all.motion(i));
    plastic_ = true;
    start_again(all), find(all, true);
    plastic_ = false;
    const auto move = [&](real part) {  // of the way from here to the solution with rebounds
      std::size_t n = 0;
      each_row([&](std::size_t, std::size_t, const joint_line&, real& r) {
        r += part * (impulses[n++] - r);
      });
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        const body_motion now = all.motion(bodies[i]), &to = motions[i];
        all.set(bodies[i], {now.v + part * (to.v - now.v), now.w + part * (to.w - now.w)});
      }
    };
    const auto none = added_energy::of(*this, all);
    move(real(0.5));
    const real part = passive_part(none, added_energy::of(*this, all), full);
    move(2 * part - 1);
  }

  /// Solves the rows that are at no bound, and repeats that with what is left of them. The
  /// residuals of rows that depend on others follow from these.
  template <class Bodies>
  void refine(Bodies& all) {
    constexpr int most = 8;
    real last = unbounded;
    for (int k = 0; k < most; ++k) {
      real left = 0, scale = 0, speed = 0;
      rest_.assign(system_.size(), 0), contradiction_ = 0;
      each_row([&](std::size_t j, std::size_t i, const joint_line& x, real& r) {
        if (held_[first[j] + i] != bound::none) return;
        const body_motion a = all.motion(joints[j].a), b = all.motion(joints[j].b);
        const real u = x.force.dot(a.v - b.v) + (x.moment_a.dot(a.w) - x.moment_b.dot(b.w));
        const real e = target_of(j, x) - u - compliance_of(j, x) * r;
        rest_[row_of(j, i)] = residuals_[first[j] + i] = e;
        real& worst = depends(j, i) ? contradiction_ : left;
        worst = larger(worst, std::abs(e));
        // The target of a spring is far above the velocity that its force gives.
        const real given = x.compliance > 0 ? 1 - x.compliance / mobility(j, x) : real(1);
        speed = std::max({speed, given * std::abs(e + u),
                          x.force.norm() * (a.v.norm() + b.v.norm()) +
                              x.moment_a.norm() * a.w.norm() + x.moment_b.norm() * b.w.norm()});
        if (factorized_) speed = std::max(speed, system_.left_of(row_of(j, i)) * std::abs(r));
        scale = std::max({scale, speed, std::abs(x.target)});
      });
      scale_ = scale, speed_ = speed, left_ = left;
      if (k == 0) first_speed_ = speed;
      const bool slow = k > 0 && !(left < real(0.5) * last);
      if (!(left > real(4e-16) * scale) || (k > 1 && slow && !stale_)) return;
      last = left;
      if (!factorized_ || (slow && stale_)) factorize();
      if (k == 0)  // impulses of rows that depend on others would grow by round-off
        each_row([&](std::size_t j, std::size_t i, const joint_line&, real& r) {
          if (held_[first[j] + i] == bound::none)
            rest_[row_of(j, i)] -= system_.added(row_of(j, i)) * r;
        });
      system_.solve(rest_);
      each_row([&](std::size_t j, std::size_t i, const joint_line& x, real& r) {
        if (held_[first[j] + i] != bound::none) return;
        const real d = -rest_[row_of(j, i)];
        r += d;
        push(all, j, x, d);
        largest_push_ = std::max(largest_push_, std::abs(d) * mobility(j, x));
      });
    }
  }
  /// Rows beyond a bound stay on it from now on, and rows that a bound keeps from holding while
  /// that is not needed leave it; one of them, or all. Returns whether there were any.
  template <class Bodies>
  bool change_bounds(const Bodies& all, bool one) {
    bool changed = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (!x.bounded() || (one && changed)) return;
      bound& held = held_[first[j] + k];
      const bound before = held;
      if (held == bound::none) {
        if (r < x.least) held = bound::least;
        if (r > x.most) held = bound::most;
      } else {
        const real excess = rate(x, all, joints[j]) + compliance_of(j, x) * r - target_of(j, x);
        const real small = 1e-12 * scale_;
        if (held == bound::least ? excess < -small : excess > small) held = bound::none;
      }
      changed = changed || held != before;
    });
    return changed;
  }
  /// Rows beyond a bound stay on it, and no row leaves one: the end of a search that has cycled.
  bool hold_beyond_bounds() {
    bool changed = false;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      bound& held = held_[first[j] + k];
      if (held != bound::none || (r >= x.least && r <= x.most)) return;
      held = r < x.least ? bound::least : bound::most;
      changed = true;
    });
    return changed;
  }
  /// Whether the solution is better with more care. Without drives no velocity grows, and impulses
  /// are larger than velocities by the ratios of masses.
  template <class Bodies>
  bool take_care(const Bodies& all) {
    constexpr real small = 1e-6, bearable = 1e-3, faster = 30, thrown_by = 20, moved_by = 60,
                   heavier = 1e4;
    const real worst = std::max(left_, contradiction_);
    const bool thrown = speed_ > 2 * first_speed_ &&
                        adds_too_much(*this, all, solves_velocities() ? thrown_by : moved_by);
    if (care_ == care::none) {
      const bool wrong =
          thrown || !(worst <= small * first_speed_ && speed_ <= faster * first_speed_);
      if (!wrong && !(largest_change() > heavier * first_speed_)) return false;
      care_ = care::more, heavy_ = !wrong;
      return true;
    }
    if (care_ == care::yields) {
      if (!thrown || softness_ >= softest) return false;
      softness_ *= 10;
      return true;
    }
    if (care_ != care::more || (worst <= bearable * first_speed_ && !thrown)) return false;
    care_ = heavy_ && !thrown ? care::in_vain : care::yields;
    return true;
  }
  /// The largest change of an impulse, as a velocity.
  [[nodiscard]] real largest_change() {
    real most = 0;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (held_[first[j] + k] == bound::none)
        most = larger(most, std::abs(r - start_[first[j] + k]) * mobility(j, x));
    });
    return most;
  }
  /// Where rows contradict each other, impulses that do not move the bodies grow until the first of
  /// them meets a bound: it stays there. Returns whether there is one.
  bool meet_bound() {
    if (!(contradiction_ > 1e-6 * first_speed_)) return false;
    rest_.assign(system_.size(), 0);
    each_row([&](std::size_t j, std::size_t k, const joint_line&, real&) {
      if (depends(j, k) && held_[first[j] + k] == bound::none)
        rest_[row_of(j, k)] = residuals_[first[j] + k];
    });
    system_.solve(rest_);
    real most = 0;
    each_row([&](std::size_t j, std::size_t k, const joint_line&, real&) {
      most = std::max(most, std::abs(rest_[row_of(j, k)]));
    });
    bound* soon = nullptr;
    bound to = bound::none;
    real soonest = unbounded;
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      bound& held = held_[first[j] + k];
      const real d = -rest_[row_of(j, k)];
      if (held != bound::none || !x.bounded() || !(std::abs(d) > 1e-9 * most)) return;
      const real when = ((d > 0 ? x.most : x.least) - r) / d;
      if (when < soonest) soonest = when, soon = &held, to = d > 0 ? bound::most : bound::least;
    });
    if (soon == nullptr) return false;
    *soon = to;
    return true;
  }

  // All impulses are added to the motions before, so that those of a trial leave no round-off.
  template <class Bodies>
  void note_motions(const Bodies& all) {
    before_.clear();
    for (const std::int32_t i : bodies) before_.push_back(all.motion(i));
  }
  template <class Bodies>
  void restore_motions(Bodies& all) const {
    for (std::size_t k = 0; k < bodies.size(); ++k) all.set(bodies[k], before_[k]);
  }
  /// Adds the impulses to the motions before once more. Where the search has passed large ones that
  /// cancel, as where rows contradict each other, their round-off is left in the motions.
  template <class Bodies>
  void add_up(Bodies& all) {
    restore_motions(all);
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      push(all, j, x, r - start_[first[j] + k]);
    });
  }
  template <class Bodies>
  void start_again(Bodies& all) {
    restore_motions(all);
    each_row([&](std::size_t j, std::size_t k, const joint_line&, real& r) {
      r = start_[first[j] + k];
    });
    move_to_bounds(all);
    factorized_ = false;
  }
  template <class Bodies>
  void move_to_bounds(Bodies& all) {
    each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      const bound held = held_[first[j] + k];
      if (held == bound::none) return;
      const real to = held == bound::least ? x.least : x.most;
      if (to == r) return;
      push(all, j, x, to - r);
      r = to;
    });
  }
  /// If the search for the right bounds has not ended.
  template <class Bodies>
  void move_within_bounds(Bodies& all) {
    bool beyond = false;
    each_row([&](std::size_t, std::size_t, const joint_line& x, real& r) {
      beyond = beyond || r < x.least || r > x.most;
    });
    if (!beyond) return;
    each_row([&](std::size_t, std::size_t, const joint_line& x, real& r) {
      r = std::clamp(r, x.least, x.most);
    });
    add_up(all);
  }

  plain_vector<bound> held_;  ///< by rows
  plain_vector<real> start_, residuals_;
  plain_vector<body_motion> before_;
  articulated_system system_;
  plain_vector<real> rest_;
  real scale_ = 0;                    ///< of the terms of the rows, at the end
  real speed_ = 0, first_speed_ = 0;  ///< of velocities, at the end and at the start
  real left_ = 0;                     ///< the largest residual of other rows
  real largest_push_ = 0;             ///< of all changes of impulses, as velocities
  real contradiction_ = 0;            ///< the largest residual of a row that depends on others
  bool factorized_ = false, stale_ = false, heavy_ = false;
  bool plastic_ = false;  ///< rebounds are left out
  care care_ = care::none;
  real softness_ = soft;  ///< of rows that yield
};

}  // namespace talus::detail
