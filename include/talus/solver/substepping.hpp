#pragma once
// Substepping: the time step is divided, and each substep has one iteration.
#include <algorithm>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/solver_settings.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/core/each.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/policy.hpp"
#include "talus/motion/integrate.hpp"
#include "talus/solver/contact_course.hpp"
#include "talus/solver/contact_list.hpp"
#include "talus/solver/convergence.hpp"
#include "talus/solver/correct_overlaps.hpp"
#include "talus/solver/sweep.hpp"

namespace talus {

/// Divides the step into `solver_settings::iterations` substeps with one Gauss-Seidel sweep each
/// (Macklin, Storey, Lu, Terdiman, Chentanez, Jeschke, Mueller 2019, "Small steps in physics
/// simulation"). Contacts are detected once per step; in between, gaps advance with the relative
/// velocities, so that an impact happens in its substep, and bodies rotate with their tensors of
/// inertia. Each substep starts from the impulses of the last one. Unlike more sweeps, more
/// substeps also refine the motion in time. Where an impact changes the velocities of two bodies,
/// their contacts are solved together: a face that strikes a floor does not turn.
///
/// With a tolerance each substep is iterated to it. After the step contacts hold the impulses of
/// the whole step; measure_residual() compares these with the velocities at its end, so that an
/// impact within the step counts as a residual.
struct substepping final {
  using talus_part_of = roles::solver;
  static constexpr const char* name = "substepping";
  static constexpr bool uses_substeps = true;

  /// Solves the contacts as nonlinear_gauss_seidel::solve does; in addition it fills
  /// solver_state::drift.
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
    detail::plain_vector<char> bound(bodies, 0);
    auto courses = std::apply(
        [&](auto&... list) { return std::tuple(courses_of(list, s, part, held, bound)...); },
        lists);
    for (std::size_t i = 0; i < bodies; ++i)  // free bodies rotate in one piece
      if (detail::rotated_body* body = s.rotated_at(i))
        if (!bound[i] && s.gain[i].w == vec3(0, 0, 0)) body->time = 0;
    each([&](auto& list) { list.prepare_interior(s); });

    detail::solved done{0, 0};
    for (int j = 0; j < settings.iterations; ++j) {
      if constexpr (!alone)
        if (j > 0) ranks.share_velocities();
      each_with(lists, courses, [&](auto& list, auto& of) {
        list.each_numbered(
            [&](auto& c, std::size_t i) { of[i].advance(c, s, part, j > 0 ? part : 0, held); });
      });
      bool rotates = false;
      for (std::size_t i = 0; i < bodies; ++i) {
        auto& [v, inverse_mass, w, inverse_inertia] = s.bodies[i];
        given[i] = {v - last[i].v - part * s.gain[i].v, w - last[i].w - part * s.gain[i].w};
        if (j > 0)
          if (detail::rotated_body* body = s.rotated_at(i)) {
            book(*body, given[i].w, last[i].w, w);
            rotates = rotate(s, i, *body, given[i].w) || rotates;
          }
        last[i] = {v, w};
        v += part * s.gain[i].v, w += part * s.gain[i].w;
      }
      if (rotates) prepare_tensors<true>(lists, s);
      detail::convergence_watch<Lists, Ranks> watch(lists, s, once, ranks);
      if (j == 0) {
        each([&](auto& list) { list.warm_start(s); });
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
      each_with(lists, courses,
                [&](auto& list, auto& of) { finish_impacts(list, of, s, 2 * part * s.speed); });
      for (std::size_t i = 0; i < bodies; ++i)
        s.drift[i].v += s.bodies[i].v, s.drift[i].w += s.bodies[i].w;
    }

    for (std::size_t i = 0; i < bodies; ++i) {
      const auto& [v, inverse_mass, w, inverse_inertia] = s.bodies[i];
      s.drift[i].v = part * s.drift[i].v - v;
      s.drift[i].w = part * s.drift[i].w - w;
      if (detail::rotated_body* body = s.rotated_at(i)) {
        book(*body, w - last[i].w - part * s.gain[i].w, last[i].w, w);
        body->spin = w;
      }
    }
    each_with(lists, courses, [&](auto& list, auto& of) {
      list.each_numbered([&](auto& c, std::size_t i) { of[i].finish(c, s, part); });
    });
    if (correct) {
      prepare_tensors<false>(lists, s);  // the rates of the correction have changed
      detail::correct_overlaps(lists, s, settings, ranks);
    }
    return done;
  }

 private:
  static constexpr real smallest_angle = 1e-8;  ///< rad, in which bodies rotate

  template <class List>
  static auto courses_of(List& list, const detail::solver_state& s, real part, real held,
                         detail::plain_vector<char>& bound) {
    using contact = typename List::contact_type;
    detail::plain_vector<detail::contact_course<contact>> all;
    all.reserve(list.size());
    list.each_numbered([&](contact& c, std::size_t) {
      all.emplace_back(c, s, part, held);
      bound[static_cast<std::size_t>(c.a)] = true;
      if constexpr (contact::paired) bound[static_cast<std::size_t>(c.b)] = true;
    });
    return all;
  }

  /// Adds up the angular impulse and the work of a substep in which contacts and joints have
  /// changed an angular velocity by `given`, from `before` to `after`.
  static void book(detail::rotated_body& body, const vec3& given, const vec3& before,
                   const vec3& after) {
    const vec3 p = body.momentum(given);
    body.angular_impulse += p;
    body.work += real(0.5) * p.dot(before + after);
  }
  /// Rotates a body, free, for the time of a substep. Angular impulses stay the same, in the world,
  /// and so `given` and the gain by torques change. Angles near round-off wait for those to come.
  static bool rotate(detail::solver_state& s, std::size_t i, detail::rotated_body& body,
                     vec3& given) {
    auto& [v, inverse_mass, w, inverse_inertia] = s.bodies[i];
    body.waiting += body.time;
    if (body.waiting * w.norm() < smallest_angle) return false;
    const vec3 by_contacts = body.momentum(given), by_torques = body.momentum(s.gain[i].w);
    w = detail::rotate_freely(body.orientation, w, body.inertia, body.waiting);
    body.waiting = 0;
    const mat3 per_mass =
        detail::inverse_tensor(body.orientation, vec3(body.inertia.cwiseInverse()));
    s.tensors[i - s.first_tensor] = inverse_mass * per_mass;
    given = per_mass * by_contacts;
    if (by_torques != vec3(0, 0, 0)) s.gain[i].w = per_mass * by_torques;
    return true;
  }
  /// Contacts, and `Joints`, of bodies with a tensor of inertia.
  template <bool Joints, class Lists>
  static void prepare_tensors(Lists& lists, detail::solver_state& s) {
    detail::each_of(lists, [&](auto& list) {
      using contact = typename std::remove_cvref_t<decltype(list)>::contact_type;
      if constexpr (detail::turns_bodies<contact> && (Joints || !detail::is_joint<contact>))
        list.prepare_again(s);
    });
  }

  /// Adds up the impulses of a substep. Where these have changed the velocities of two bodies with
  /// several contacts by more than `speed`, as in an impact, one sweep has left a rotation: these
  /// contacts are solved together.
  template <class List, class Courses>
  static void finish_impacts(List& list, Courses& of, detail::solver_state& s, real speed) {
    using contact = typename List::contact_type;
    constexpr auto interior = detail::contact_part::interior;
    if constexpr (detail::comes_in_manifolds<contact> && !detail::is_joint<contact>)
      for (std::size_t first = 0, last = 0, n = list.size(interior); first < n; first = last) {
        bool struck = false;
        while (last < n && list.key(interior, last).same_pair(list.key(interior, first))) {
          list.edit(interior, last,
                    [&](const contact& c) { struck = of[last].changes(c, s, speed) || struck; });
          ++last;
        }
        if (struck && last > first + 1) solve_together(list, first, last, s);
      }
    list.each_numbered([&](auto& c, std::size_t i) { of[i].add(c); });
  }
  template <class List>
  static void solve_together(List& list, std::size_t first, std::size_t last,
                             detail::solver_state& s) {
    using contact = typename List::contact_type;
    constexpr auto interior = detail::contact_part::interior;
    constexpr int most = 50;
    const auto each = [&](auto&& f) {
      for (std::size_t i = first; i < last; ++i) list.edit(interior, i, f);
    };
    real largest = 0;
    each([&](contact& c) {
      c.prepare(s, 1, 1);
      largest = std::max(largest, c.speed_of(c.impulse_in_frame()));
    });
    for (int k = 0; k < most; ++k) {
      real change = 0;
      each([&](contact& c) {
        const auto d = c.relax(s);
        c.apply(s, d);
        change = std::max(change, c.speed_of(d));
      });
      if (!(change > real(1e-10) * largest)) return;
    }
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
