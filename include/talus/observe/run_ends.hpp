#pragma once
// Conditions for the end of a run, for world.stop_when(...) and .stop_when of simulate(): all
// bodies are at rest, or an observable is steady. All ranks decide alike, by reductions.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/observe/penetration.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// When bodies count as being at rest.
struct rest {
  /// The largest speed at rest, where the speed of a body includes its rotation: sqrt(2 E/m) of its
  /// kinetic energy E. 0: the speed at which a body rises by 1e-4 of the mean radius against
  /// gravity, sqrt(2e-4 g r).
  real speed = 0;
  /// How long all bodies are slower than that, in units of time. 0: the time to fall by the mean
  /// diameter, sqrt(4 r/g).
  real time = 0;
};

/// When an observable counts as steady.
struct steadiness {
  /// The length of the window, in units of time: several periods of whatever fluctuates.
  real time = 0;
  /// The means over the two halves of the window differ by at most this part of the mean size of
  /// the observable.
  real within = 0.01;
};

namespace detail {

/// Collective: the largest sqrt(2 E/m) of the bodies that can move.
template <class Scenario>
[[nodiscard, gnu::cold]] real largest_speed_with_spin(world<Scenario>& w) {
  double fastest = 0;
  w.for_each_local([&](const auto& b) {
    if (b.is_fixed()) return;
    const vec3 spin = b.angular_velocity(), inertia = b.inertia();
    real of_spin = inertia[0] * spin.dot(spin);
    if constexpr (!std::remove_cvref_t<decltype(b)>::shape_type::isotropic) {
      const vec3 local = b.orientation().conjugate() * spin;
      of_spin = local.dot(vec3(inertia.cwiseProduct(local)));
    }
    const vec3 v = b.velocity();
    fastest = std::max(fastest, v.dot(v) + of_spin / b.mass());
  });
  w.link().reduce(reduction::max, std::span(&fastest, 1));
  return std::sqrt(fastest);
}

/// What a condition remembers from one look to the next. One class for both conditions, because
/// each shared pointer to another class is compiled into every program.
class end_watch {
 public:
  end_watch() = default;
  explicit end_watch(const steadiness& how) : how_(how) {}
  /// Forgets everything: simulate() begins.
  void clear() { quiet_since_ = -1, times_.clear(), values_.clear(); }
  /// Whether all bodies have been slow for `time`, if they are `slow` at the time `now`.
  [[nodiscard, gnu::cold]] bool rests(bool slow, real now, real time);
  /// Takes a value of an observable; whether it is steady. Throws runtime_error for one that is not
  /// finite.
  [[nodiscard, gnu::cold]] bool take(real time, real value);

 private:
  real quiet_since_ = -1;  ///< negative: they are not slow
  steadiness how_{};
  plain_vector<real> times_, values_;
};

[[gnu::cold]] void require_sane(const rest& how);
[[gnu::cold]] void require_gravity(real gravity);

/// Collective: whether all bodies have been at rest. Fills in what `how` leaves open.
template <class Scenario>
[[nodiscard, gnu::cold]] bool all_rest(world<Scenario>& w, rest& how, end_watch& watch) {
  if (how.speed == 0 || how.time == 0) {
    const real g = w.gravity().norm(), radius = mean_radius(w);
    require_gravity(g);
    if (how.speed == 0) how.speed = std::sqrt(2e-4 * g * radius);
    if (how.time == 0) how.time = std::sqrt(4 * radius / g);
  }
  return watch.rests(largest_speed_with_spin(w) <= how.speed, w.time(), how.time);
}
[[gnu::cold]] void require_sane(const steadiness& how);

}  // namespace detail

/// The condition that all bodies have been at rest for a while: `.stop_when = at_rest(world)`, or
/// `world.stop_when(every{10}, at_rest(world, {.speed = 1e-3, .time = 0.5}))`. It is evaluated on
/// all ranks. Each call of simulate() counts the time anew, and so does a restart. Throws
/// invalid_argument for values that are negative or not finite; the condition throws
/// invalid_argument without gravity for a speed or a time that is not given.
template <class Scenario>
[[nodiscard, gnu::cold]] std::function<bool()> at_rest(world<Scenario>& w, rest how = {}) {
  detail::require_sane(how);
  const auto watch = std::make_shared<detail::end_watch>();
  w.before_simulating([watch] { watch->clear(); });
  return [&w, how, watch]() mutable { return detail::all_rest(w, how, *watch); };
}

/// The condition that `observable(world)`, a number that is the same on all ranks, is steady:
/// `world.stop_when(every{10}, steady(world, {.time = 5}, [](auto& w) { return
/// measure_motion(w).kinetic_energy; }))`. It is evaluated on all ranks, so that the observable may
/// be collective. Each call of simulate() begins with an empty window, and so does a restart.
/// Throws invalid_argument for a time or a part that is not positive; the condition throws
/// runtime_error for a value that is not finite.
template <class Scenario, class Observable>
[[nodiscard]] std::function<bool()> steady(world<Scenario>& w, const steadiness& how,
                                           Observable observable) {
  detail::require_sane(how);
  const auto watch = std::make_shared<detail::end_watch>(how);
  w.before_simulating([watch] { watch->clear(); });
  return [&w, watch, observable = std::move(observable)]() mutable {
    return watch->take(w.time(), observable(w));
  };
}

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/observe/run_ends_definitions.hpp"
#endif
