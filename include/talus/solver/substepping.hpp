#pragma once
// Substepping: the time step is divided, and each substep has one iteration.
#include <algorithm>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/rebound.hpp"
#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/policy.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/solver/convergence.hpp"
#include "talus/solver/correct_overlaps.hpp"
#include "talus/solver/sweep.hpp"

namespace talus {

namespace detail {

/// State of a contact in a step with substeps.
template <class Contact>
struct contact_course {
  real gap = 0;          ///< over the length of the whole step; an overlap counts as 0
  real restitution = 0;  ///< if the detection predicted an impact
  typename Contact::change total;

  /// From the conditions of the detection, which are documented in conditions_of of
  /// step/detect.hpp.
  contact_course(const Contact& c, const solver_state& s)
      : gap(c.target_velocity < 0   ? -c.target_velocity
            : c.target_velocity > 0 ? std::max(real{0}, -c.correction_rate)
                                    : 0),
        total(0 * c.impulse_in_frame()) {
    if (c.target_velocity > 0)
      restitution = std::clamp(-c.target_velocity / approach(c, s), real{0}, real{1});
  }

  /// Sets the conditions of the contact in the coming substep, from the velocities before it.
  /// `moved` is the part of the step for which surfaces have moved with these, and `held` a gap
  /// that counts as closed.
  void advance(Contact& c, const solver_state& s, real part, real moved, real held) {
    const real un = approach(c, s);
    gap = std::max(real{0}, gap + un * moved);
    c.target_velocity = gap > held || restitution > 0 ? -gap / part : 0;
    if (restitution == 0 || un >= 0 || gap + un * part > 0) return;
    const real fall = -c.axis().dot(gain(c, s));  // the length of the whole step is 1 here
    c.target_velocity = rebound(restitution, un, gap, part, fall);
  }

 private:
  static vec3 gain(const Contact& c, const solver_state& s) {
    vec3 v = s.gain[static_cast<std::size_t>(c.a)].v;
    if constexpr (Contact::paired) v -= s.gain[static_cast<std::size_t>(c.b)].v;
    return v;
  }
  static real approach(const Contact& c, const solver_state& s) {
    return c.axis().dot(c.relative_velocity(s));
  }
};

/// The same of a joint, whose conditions do not change.
template <class Contact>
requires is_joint<Contact>
struct contact_course<Contact> {
  typename Contact::change total;

  contact_course(const Contact& c, const solver_state&) : total(0 * c.impulse_in_frame()) {}
  void advance(Contact&, const solver_state&, real, real, real) {}
};

}  // namespace detail

/// Divides the step into `solver_settings::iterations` substeps with one Gauss-Seidel sweep each
/// (Macklin, Storey, Lu, Terdiman, Chentanez, Jeschke, Mueller 2019, "Small steps in physics
/// simulation"). Contacts are detected once per step; in between, gaps advance with the relative
/// velocities, so that an impact happens in its substep. Each substep starts from the impulses of
/// the last one. Unlike more sweeps, more substeps also refine the motion in time.
///
/// With a tolerance each substep is iterated to it. After the step contacts hold the impulses of
/// the whole step; measure_residual() compares these with the velocities at its end, so that an
/// impact within the step counts as a residual.
struct substepping final {
  using talus_part_of = roles::solver;
  static constexpr const char* name = "substepping";
  static constexpr bool uses_substeps = true;

  /// As nonlinear_gauss_seidel::solve; in addition it fills solver_state::drift.
  template <class Lists, class Ranks>
  static detail::solved solve(Lists& lists, detail::solver_state& s,
                              const solver_settings& settings, bool correct, Ranks&& ranks) {
    const auto each = [&](auto&& f) { detail::each_of(lists, f); };
    constexpr bool alone = std::remove_cvref_t<Ranks>::alone;
    const std::size_t bodies = s.bodies.size();
    const real part = real{1} / settings.iterations;
    const real held = s.speed;  // as in detection, and for the same reason
    solver_settings once = settings;
    once.iterations = 1;
    detail::plain_vector<detail::body_motion> last(bodies), given(bodies);
    s.drift.assign(bodies, {});
    for (std::size_t i = 0; i < bodies; ++i)
      s.bodies[i].v -= s.gain[i].v, s.bodies[i].w -= s.gain[i].w;
    auto courses =
        std::apply([&](auto&... list) { return std::tuple(courses_of(list, s)...); }, lists);
    each([&](auto& list) { list.prepare_interior(s); });

    detail::solved done{0, 0};
    for (int j = 0; j < settings.iterations; ++j) {
      if constexpr (!alone)
        if (j > 0) ranks.share_velocities();
      each_with(lists, courses, [&](auto& list, auto& of) {
        list.each_numbered(
            [&](auto& c, std::size_t i) { of[i].advance(c, s, part, j > 0 ? part : 0, held); });
      });
      for (std::size_t i = 0; i < bodies; ++i) {
        auto& [v, inverse_mass, w, inverse_inertia] = s.bodies[i];
        const vec3 dv = part * s.gain[i].v, dw = part * s.gain[i].w;
        given[i] = {v - last[i].v - dv, w - last[i].w - dw};
        last[i] = {v, w};
        v += dv, w += dw;
      }
      detail::convergence<Lists, Ranks> watch(lists, s, once, ranks);
      if (j == 0) {
        each([&](auto& list) {
          list.each_numbered([&](auto& c, std::size_t) { c.set(part * c.impulse_in_frame()); });
          list.warm_start(s);
        });
        if constexpr (!alone) {
          each([&](auto& list) { list.count_boundary(s); });
          ranks.share_velocities_and_counts();
          each([&](auto& list) { list.prepare_boundary(s); });
        }
      } else {
        for (std::size_t i = 0; i < bodies; ++i)
          s.bodies[i].v += given[i].v, s.bodies[i].w += given[i].w;
      }
      const detail::solved now = iterate(lists, s, watch, ranks);
      done.iterations += now.iterations;
      if (!(done.residual >= now.residual)) done.residual = now.residual;
      each_with(lists, courses, [&](auto& list, auto& of) {
        list.each_numbered(
            [&](auto& c, std::size_t i) { of[i].total = of[i].total + c.impulse_in_frame(); });
      });
      for (std::size_t i = 0; i < bodies; ++i)
        s.drift[i].v += s.bodies[i].v, s.drift[i].w += s.bodies[i].w;
    }

    for (std::size_t i = 0; i < bodies; ++i) {
      s.drift[i].v = part * s.drift[i].v - s.bodies[i].v;
      s.drift[i].w = part * s.drift[i].w - s.bodies[i].w;
    }
    each_with(lists, courses, [&](auto& list, auto& of) {
      list.each_numbered([&](auto& c, std::size_t i) { c.set(of[i].total); });
    });
    if (correct) detail::correct_overlaps(lists, s, settings, ranks);
    return done;
  }

 private:
  template <class List>
  static auto courses_of(List& list, const detail::solver_state& s) {
    using contact = typename List::contact_type;
    detail::plain_vector<detail::contact_course<contact>> all;
    all.reserve(list.size());
    list.each_numbered([&](contact& c, std::size_t) { all.emplace_back(c, s); });
    return all;
  }
  template <class Lists, class Others, class F>
  static void each_with(Lists& lists, Others& others, F&& f) {
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      (f(std::get<I>(lists), std::get<I>(others)), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<Lists>>{});
  }

  /// Sweeps of one substep, without a tolerance a single one. The first goes forward in every
  /// substep: with alternating directions, the errors that a sweep leaves would grow with period
  /// two.
  template <class Lists, class Watch, class Ranks>
  static detail::solved iterate(Lists& lists, detail::solver_state& s, Watch& watch, Ranks& ranks) {
    int k = 0;
    for (; k < watch.limit(); ++k) {
      if (watch.reached(k)) break;
      detail::relax_boundary<Ranks>(lists, s);
      detail::sweep_interior(lists, s, k % 2 == 0, k + 1 < watch.limit(), ranks);
      watch.poll();
    }
    return watch.end(k, [&] { ranks.share_velocities(); });
  }
};

/// The former name.
using small_steps = substepping;

}  // namespace talus
