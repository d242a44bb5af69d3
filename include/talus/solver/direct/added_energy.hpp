#pragma once
// What the impulses of joints add to the kinetic energy, and how much of a rebound adds none.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "talus/body/jointed_body.hpp"
#include "talus/constraint/joint_line.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/solver/direct/articulated_rows.hpp"

namespace talus::detail {

/// The sums of the present impulses of rows on each of their bodies, of those rows that f(line)
/// chooses.
template <class F>
[[nodiscard]] plain_vector<wrench> loads_of(articulated_rows& rows, F&& f) {
  plain_vector<wrench> loads(rows.bodies.size());
  rows.each_row([&](std::size_t j, std::size_t, const joint_line& x, real& r) {
    if (!f(x)) return;
    const auto load = [&](std::int32_t i, real p, const vec3& moment) {
      if (i < 0) return;
      wrench& of_body = loads[articulated_rows::at(i)];
      of_body.impulse += p * x.force, of_body.moment += p * moment;
    };
    load(rows.ties[j].a, r, x.moment_a), load(rows.ties[j].b, -r, x.moment_b);
  });
  return loads;
}

/// The work of the impulses of conditions and limits. They add energy only if both works are above
/// 0: that on the mean of the velocities without and with them is at most 0 if no limit rebounds,
/// but gravity and motors may do work against them; that on the mean of the velocities before and
/// after the step is at most 0 if one limit rebounds and all other rows have held before.
struct added_energy {
  real of_step = 0, of_impulses = 0;
  real size = 0;  ///< sum of the absolute values of the terms

  [[nodiscard]] real least() const { return std::min(of_step, of_impulses); }
  [[nodiscard]] bool any() const { return least() > real(4e-15) * size; }

  /// The energy that the rows add with their present impulses, on bodies with their present
  /// motions.
  template <class Bodies>
  [[nodiscard]] static added_energy of(articulated_rows& rows, const Bodies& all) {
    added_energy sum;
    rows.each_row([&](std::size_t j, std::size_t k, const joint_line& x, real& r) {
      if (drives(x.use)) return;
      const real before = rows.joints[j].before[k], now = rows.rate(x, all, rows.joints[j]);
      sum.of_step += real(0.5) * r * (before + now), sum.of_impulses += r * now;
      sum.size += std::abs(r) * (std::abs(before) + std::abs(now));
    });
    const auto loads = loads_of(rows, [](const joint_line& x) { return !drives(x.use); });
    for (std::size_t i = 0; i < loads.size(); ++i)
      sum.of_impulses -=
          real(0.5) * (rows.inverse_mass[i] * loads[i].impulse.squaredNorm() +
                       loads[i].moment.dot(rows.inverse_inertia[i] * loads[i].moment));
    return sum;
  }
};

/// Whether the present impulses give bodies far more energy than they have without these and than
/// each row alone needs to follow what drives it: its target, and bodies of prescribed motion. A
/// mechanism that these pull almost to the end of its reach would have to become as fast: by more
/// than the factor `faster`.
template <class Bodies>
[[nodiscard]] bool adds_too_much(articulated_rows& rows, const Bodies& all, real faster) {
  constexpr real rounding = 1e-3;
  const auto loads = loads_of(rows, [](const joint_line&) { return true; });
  real with = 0, without = 0, driven = 0, heaviest = 0, lightest = std::numeric_limits<real>::max();
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const real mass = 1 / rows.inverse_mass[i];
    heaviest = std::max(heaviest, mass), lightest = std::min(lightest, mass);
    const mat3 inertia = rows.inverse_inertia[i].inverse();
    const auto energy = [&](const vec3& v, const vec3& w) {
      return mass * v.squaredNorm() + w.dot(inertia * w);
    };
    const body_motion now = all.motion(rows.bodies[i]);
    with += energy(now.v, now.w);
    without += energy(now.v - rows.inverse_mass[i] * loads[i].impulse,
                      now.w - rows.inverse_inertia[i] * loads[i].moment);
  }
  rows.each_row([&](std::size_t j, std::size_t, const joint_line& x, real& r) {
    const real mobility = rows.mobility(j, x);
    if (r == 0 || !(mobility > 0)) return;  // a limit that is not reached drives nothing
    real target = std::abs(x.target);
    const auto add = [&](std::int32_t tie, std::int32_t body, const vec3& moment) {
      if (tie >= 0) return;
      const body_motion of = all.motion(body);
      target += std::abs(x.force.dot(of.v) + moment.dot(of.w));
    };
    add(rows.ties[j].a, rows.joints[j].a, x.moment_a);
    add(rows.ties[j].b, rows.joints[j].b, x.moment_b);
    driven += target * target / mobility;
  });
  // A row of light bodies may move heavy ones.
  return with > (1 + rounding) * without + faster * faster * (heaviest / lightest) * driven;
}

/// The largest part of the way between two solutions that adds no energy: the first adds none, the
/// second some. Both works are quadratic functions of the part.
[[nodiscard]] inline real passive_part(const added_energy& none, const added_energy& half,
                                       const added_energy& all) {
  const auto at = [](real from, real middle, real to, real part) {
    const real square = 2 * (from + to) - 4 * middle;
    return from + part * (to - from - square + part * square);
  };
  real part = 0;
  for (real step = real(0.5); step > real(1e-16); step *= real(0.5)) {
    const real next = part + step;
    if (at(none.of_step, half.of_step, all.of_step, next) <= 0 ||
        at(none.of_impulses, half.of_impulses, all.of_impulses, next) <= 0)
      part = next;
  }
  return part;
}

}  // namespace talus::detail
