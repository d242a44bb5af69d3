#pragma once
// The stopping criterion of a solver: a number of iterations, or a small enough contact residual.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "talus/constraint/residual.hpp"
#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The result of a solver in one step; alike on all ranks.
struct solved {
  int iterations = 0;
  /// Contact residual of the solution, NaN without a tolerance.
  double residual = std::numeric_limits<double>::quiet_NaN();
};

/// Checks the residual while a solver iterates, if a tolerance is set; otherwise it only counts.
/// Ranks agree by one reduction per check, so that all stop after the same iteration; all but the
/// last reduction overlap with an iteration. Checks become rarer with the iterations (every eighth
/// of their number), which keeps their cost below that of the iterations. `Sum` is double, or
/// exact_sum if the result must not depend on the distribution of contacts.
///
///   // before any impulse acts:
///   convergence_watch<Lists, Ranks, State> watch(lists, state, settings, ranks);
///   int k = 0;
///   for (; k < watch.limit(); ++k) {
///     ...                           // all ranks hold the velocities after k iterations
///     if (watch.reached(k)) break;
///     ...                           // iterate
///     watch.poll();
///   }
template <class Lists, class Ranks, class State = solver_state, class Sum = double>
class convergence_watch {
  static constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
  /// If nothing may depend on the ranks, a single rank gets the result as late as several.
  static constexpr bool at_once = alone && std::is_same_v<Sum, double>;

 public:
  /// Checks are at least `apart` iterations from each other.
  convergence_watch(const Lists& lists, const State& s, const solver_settings& settings,
                    Ranks& ranks, int apart = 1)
      : lists_(lists),
        s_(s),
        settings_(settings),
        ranks_(ranks),
        apart_(apart),
        watches_(settings.tolerance > 0) {
    if (!watches_) return;
    scale_ = scale_of<Sum>(lists, s);
    start_sum(scale_.sums);
    opening_ = true;
  }

  [[nodiscard]] int limit() const {
    return watches_ ? settings_.max_iterations : settings_.iterations;
  }
  [[nodiscard]] bool monitored() const { return watches_; }

  /// Whether the velocities after `k` iterations will be checked.
  [[nodiscard]] bool due(int k) const { return watches_ && k >= next_; }

  /// Checks the velocities after `k` iterations, if that is due: returns whether they are the
  /// solution.
  bool reached(int k) {
    if (!due(k)) return false;
    looked_ = k;
    next_ = k + std::max(apart_, k / 8);
    look();
    if (at_once || hopeful_) settled_ = conclude();
    hopeful_ = false;
    return settled_;
  }
  /// The problem has changed since it was solved.
  void look_again() { settled_ = false; }
  /// The last one found, by all ranks; NaN before.
  [[nodiscard]] double residual() const { return residual_; }

  /// Receives the ranks' residual of one iteration ago. If it was small enough, the next check is
  /// made at once, or after `grace` more iterations, and awaited, so that the final velocities are
  /// those that passed.
  void poll(int grace = 0) {
    if constexpr (!at_once) {
      if (!looking_) return;
      hopeful_ = conclude();
      if (hopeful_) next_ = looked_ + 1 + grace;
    }
  }
  /// After the last of `k` iterations. If the tolerance was not reached, `refresh` is called to
  /// send the velocities to all ranks, and the residual is that of the final velocities.
  template <class Refresh>
  [[nodiscard]] solved end(int k, Refresh&& refresh) {
    if (watches_ && !settled_) {
      if constexpr (!alone) refresh();
      look();
      conclude();
    }
    return {k, residual_};
  }

 private:
  void look() {
    if (opening_) finish_sum(scale_.sums);
    opening_ = false;
    now_ = sums_of<Sum>(lists_, s_, scale_.rho());
    start_sum(now_.sums);
    looking_ = true;
  }
  bool conclude() {
    finish_sum(now_.sums);
    looking_ = false;
    residual_ = now_.value(scale_);
    return residual_ <= settings_.tolerance;
  }

  /// Over all ranks; exact sums are sent digit by digit.
  template <std::size_t N>
  void start_sum(std::array<Sum, N>& sums) {
    if constexpr (alone) {
      return;
    } else if constexpr (std::is_same_v<Sum, double>) {
      ranks_.start_reduce(sums);
    } else {
      constexpr std::size_t size = Sum::digits + 1;
      digits_.resize(N * size);
      for (std::size_t k = 0; k < N; ++k)
        sums[k].write(std::span<double, size>(digits_.data() + k * size, size));
      ranks_.start_reduce(digits_);
    }
  }
  template <std::size_t N>
  void finish_sum(std::array<Sum, N>& sums) {
    if constexpr (alone) {
      return;
    } else if constexpr (std::is_same_v<Sum, double>) {
      ranks_.finish_reduce(sums);
    } else {
      constexpr std::size_t size = Sum::digits + 1;
      ranks_.finish_reduce(digits_);
      for (std::size_t k = 0; k < N; ++k)
        sums[k].read(std::span<const double, size>(digits_.data() + k * size, size));
    }
  }

  const Lists& lists_;
  const State& s_;
  const solver_settings& settings_;
  Ranks& ranks_;
  int apart_;
  bool watches_;
  bool opening_ = false, looking_ = false;  ///< a reduction is open: of the scale, of a check
  bool hopeful_ = false, settled_ = false;
  int next_ = 0, looked_ = 0;  ///< iterations before the next check, and before the last
  residual_scale_of<Sum> scale_;
  residual_sums_of<Sum> now_;
  plain_vector<double> digits_;
  double residual_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace talus::detail
