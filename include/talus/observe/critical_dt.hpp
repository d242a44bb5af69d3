#pragma once
// The longest time step that soft contacts allow.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/detect/flush.hpp"
#include "talus/interaction/soft_state.hpp"
#include "talus/interaction/stiffening.hpp"
#include "talus/interaction/time_step.hpp"
#include "talus/parallel/reduction.hpp"
#include "talus/world/bond_time_step.hpp"
#include "talus/world/world.hpp"

namespace talus {

namespace detail {

/// The data that determine the time step of soft contacts: the same on all ranks.
struct soft_scales {
  /// By material, of the body that moves with the least mass over stiffening(): its mass, else
  /// infinite, its stiffening(), and the radius of the sphere of its volume, of equals the least.
  std::vector<real> lightest, stiffest, radius;
  /// By pair of materials: the longest step that is stable for all bodies of the first.
  std::vector<real> stable;
  std::vector<char> wall;  ///< by material: whether a body of it is immovable
  real of_bodies = std::numeric_limits<real>::infinity();  ///< longest step stable for all bodies
  real speed = 0;    ///< estimated, of the fastest impact: of present motion, and of a fall
  real gravity = 0;  ///< its size

  [[nodiscard]] bool moves(std::size_t m) const { return std::isfinite(lightest[m]); }
};

/// How far a body may fall onto a plane.
template <class Scenario>
[[nodiscard]] real fall_to_planes(const world<Scenario>& w, const vec3& from, const vec3& down) {
  real furthest = 0;
  state_of(w).each_shape([&](const auto& b) {
    for (const auto& shape : b.global.shape)
      if constexpr (requires { shape.unit_normal(); }) {
        const real towards = -shape.unit_normal().dot(down);
        if (towards > 0) furthest = std::max(furthest, shape.distance(from) / towards);
      }
  });
  return furthest;
}

/// Collective: the largest number of corners of a face of a body on which another body with corners
/// may lie; 0 if there is one such body or less.
template <class Scenario>
[[nodiscard]] int corners_of_others(world<Scenario>& w) {
  real minus_most = 0, bodies = 0;
  w.for_each_known([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (shape::finite && !is_triangulated<shape>) {
      if (b.is_remote()) return;
      const int corners = most_corners_of_face(b.shape());
      if (corners <= 2) return;
      ++bodies, minus_most = std::min(minus_most, real(-corners));
    }
  });
  w.link().reduce(reduction::min, std::span(&minus_most, 1));
  w.link().reduce(reduction::sum, std::span(&bodies, 1));
  return bodies > 1 ? static_cast<int>(-minus_most) : 0;
}

/// For each material, the bodies for which no other body is both lighter and stiffer. Of two bodies
/// that are alike in both, the smaller one.
class soft_extremes {
 public:
  explicit soft_extremes(std::size_t materials) : of_(materials) {}
  void add(std::size_t material, real mass, real stiffer, real volume) {
    auto& all = of_[material];
    const auto before = [](const body& x, const body& y) {
      const bool alike = x.mass == y.mass && x.stiffer == y.stiffer;
      return alike ? x.volume <= y.volume : x.mass <= y.mass && x.stiffer >= y.stiffer;
    };
    const body one{mass, stiffer, volume};
    for (const body& x : all)
      if (before(x, one)) return;
    std::erase_if(all, [&](const body& x) { return before(one, x); });
    all.push_back(one);
  }
  /// Calls f(mass, stiffening, volume) for those of a material.
  template <class F>
  void each(std::size_t material, F&& f) const {
    for (const body& x : of_[material]) f(x.mass, x.stiffer, x.volume);
  }

 private:
  struct body {
    real mass, stiffer, volume;
  };
  std::vector<std::vector<body>> of_;
};

/// Collective.
template <class Scenario>
[[nodiscard, gnu::cold]] soft_scales measure_soft_scales(world<Scenario>& w) {
  using law = typename Scenario::contact_law::law;
  constexpr real never = std::numeric_limits<real>::infinity();
  const material_table& materials = w.materials();
  const std::size_t n = materials.size();
  const real gravity = w.gravity().norm();
  const vec3 down = gravity > 0 ? vec3(w.gravity() / gravity) : vec3(0, 0, 0);
  // Minima over all ranks: first two for each material, the least mass over stiffening and whether
  // it is a wall, then the rest, some with a minus.
  enum : std::size_t { of_bodies, minus_speed, minus_driven, minus_fall, minus_top, bottom, rest };
  std::vector<real> least(2 * n + rest, never);
  const auto lower = [&](std::size_t which, real value) {
    least[which] = std::min(least[which], value);
  };
  const int of_others = corners_of_others(w);
  soft_extremes extremes(n);
  lower(2 * n + minus_speed, 0), lower(2 * n + minus_driven, 0), lower(2 * n + minus_fall, 0);
  real moving = 0;
  w.for_each_known([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if (b.is_remote()) return;
    const auto m = static_cast<std::size_t>(b.material());
    if constexpr (shape::finite) {
      const vec3 half = b.shape().half_extents(b.pose());
      const real height = -down.dot(b.position()), below = std::abs(down[0]) * half[0] +
                                                           std::abs(down[1]) * half[1] +
                                                           std::abs(down[2]) * half[2];
      lower(2 * n + bottom, height - below);
      if (!b.is_fixed()) {
        ++moving;
        const real stiffer = stiffening(b.shape(), of_others);
        extremes.add(m, b.mass(), stiffer, b.shape().volume());
        lower(m, b.mass() / stiffer);
        lower(2 * n + minus_speed, -b.velocity().norm());
        lower(2 * n + minus_top, -(height - below));
        lower(2 * n + minus_fall, -fall_to_planes(w, b.position() + below * down, down));
        if constexpr (law::bounds_each_body) {
          const auto bound = [&](const material& of) {
            lower(2 * n + of_bodies,
                  law::longest_step_of_body(of, wave_radius(b.shape())) / std::sqrt(stiffer));
          };
          const real volume = b.shape().volume();
          const material& usual = materials[b.material()];
          if (b.mass() == usual.density * volume) {
            bound(usual);
          } else {
            material own = usual;
            own.density = b.mass() / volume;
            bound(own);
          }
        }
        return;
      }
    }
    lower(n + m, 0);
    lower(2 * n + minus_driven, -b.velocity().norm());
  });
  if constexpr (world_state<Scenario>::drives)
    for (const auto& one : state_of(w).driving.all)
      if (one->is_servo) lower(2 * n + minus_driven, -one->holds.max_speed);
  w.link().reduce(reduction::min, std::span(least));
  w.link().reduce(reduction::sum, std::span(&moving, 1));

  soft_scales s;
  s.lightest.assign(n, never), s.radius.assign(n, never), s.stable.assign(n * n, never);
  auto& pairs = state_of(w).soft.pairs;
  pairs.follow(materials);
  for (std::size_t m = 0; m < n; ++m)
    extremes.each(m, [&](real mass, real stiffer, real) {
      if (mass / stiffer == least[m]) s.lightest[m] = std::min(s.lightest[m], mass);
      for (std::size_t j = 0; j < n; ++j)
        if (const auto& pair = pairs.pair(static_cast<material_id>(m), static_cast<material_id>(j));
            pair.known)
          s.stable[m * n + j] =
              std::min(s.stable[m * n + j], real(law::longest_step(pair, mass, stiffer)));
    });
  w.link().reduce(reduction::min, std::span(s.lightest));
  for (std::size_t m = 0; m < n; ++m)
    extremes.each(m, [&](real mass, real stiffer, real volume) {
      if (mass / stiffer == least[m] && mass == s.lightest[m])
        s.radius[m] = std::min(s.radius[m], portable::cbrt(volume * (3 / (4 * pi))));
    });
  w.link().reduce(reduction::min, std::span(s.radius));
  w.link().reduce(reduction::min, std::span(s.stable));
  for (std::size_t m = 0; m < n; ++m)
    s.wall.push_back(least[n + m] == 0), s.stiffest.push_back(s.lightest[m] / least[m]);
  const auto rest_of = [&](std::size_t which) { return least[2 * n + which]; };
  s.of_bodies = rest_of(of_bodies);
  s.gravity = gravity;
  const real closing = -(moving > 1 ? 2 : 1) * rest_of(minus_speed) - rest_of(minus_driven);
  const real spread = moving > 0 ? -rest_of(minus_top) - rest_of(bottom) : 0;
  const real fall = gravity > 0 ? std::max(spread, -rest_of(minus_fall)) : 0;
  s.speed = std::sqrt(closing * closing + 2 * gravity * fall);
  return s;
}

/// Calls f(i, j, parameters) for the materials of bodies that may meet, the first of which moves.
template <class Scenario, class F>
void each_meeting_pair(world<Scenario>& w, const soft_scales& s, F&& f) {
  auto& pairs = state_of(w).soft.pairs;
  const material_table& materials = w.materials();
  pairs.follow(materials);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (!s.moves(i)) continue;
    for (std::size_t j = 0; j < materials.size(); ++j) {
      if (!s.moves(j) && !s.wall[j]) continue;
      const auto& pair = pairs.pair(static_cast<material_id>(i), static_cast<material_id>(j));
      if (pair.known) f(i, j, pair);
    }
  }
}

/// The shortest contact of the present bodies at this speed, infinite if there is none; only
/// impacts count, not bodies coming to rest.
template <class Scenario>
[[nodiscard]] real shortest_contact(world<Scenario>& w, const soft_scales& s, real speed) {
  using law = typename Scenario::contact_law::law;
  real shortest = std::numeric_limits<real>::infinity();
  if (!(speed > 0)) return shortest;
  each_meeting_pair(w, s, [&](std::size_t i, std::size_t j, const auto& pair) {
    real of_mass = s.stiffest[i] / s.lightest[i], curvature = 1 / s.radius[i];
    if (s.moves(j)) of_mass += s.stiffest[j] / s.lightest[j], curvature += 1 / s.radius[j];
    const real time = law::duration(pair, head_on_impact{1 / of_mass, 1 / curvature, speed});
    if (is_impact(speed, time, s.gravity)) shortest = std::min(shortest, time);
  });
  return shortest;
}

/// Above it contacts gain energy, or waves in the bodies are not resolved (Hertz).
template <class Scenario>
[[nodiscard]] real longest_stable_step(world<Scenario>& w, const soft_scales& s) {
  real least = s.of_bodies;
  each_meeting_pair(w, s, [&](std::size_t i, std::size_t j, const auto&) {
    least = std::min(least, s.stable[i * s.lightest.size() + j]);
  });
  if constexpr (has_bonds<Scenario>) least = std::min(least, longest_step_of_bonds(w));
  return least;
}

/// Collective: the warning about a time step that is not stable for the present bodies, alike on
/// all ranks, or nothing.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string unstable_step(world<Scenario>& w, real dt) {
  const real longest = longest_stable_step(w, measure_soft_scales(w));
  if (!(dt > longest)) return {};
  return compose(
      "dt {} is above the critical time step {} of the soft contacts: the results will mean "
      "nothing; take a fifth of it or less",
      text(dt, 6), text(longest, 4));
}

/// The critical time step for impacts of this speed, from data that measure_soft_scales() has
/// measured.
template <class Scenario>
[[nodiscard]] real critical_step(world<Scenario>& w, const soft_scales& s, real speed) {
  return std::min(longest_stable_step(w, s), shortest_contact(w, s, speed) / steps_in_critical);
}

}  // namespace detail

/// Collective: the critical time step of a soft scenario for impacts of the given relative speed,
/// infinite if nothing moves. A fifth of it is common: at that step a contact takes 20 steps or
/// more, and the motion is stable. It is the smaller of two values. Stability: for linear springs
/// the step beyond which a contact of a body with one like it gains energy; for Hertz the shortest
/// Rayleigh time of all bodies; for bonds a bound for all bonds of a body. Boxes, hulls, cylinders,
/// capsules, unions and shapes of one's own that may have flat sides count as on the contact points
/// of two faces, about which they also turn (see interaction/stiffening.hpp); a surface of
/// triangles counts as a plane. Resolution: 5/21 of the shortest contact at that speed, if that is
/// an impact: faster than gravity times the duration of the contact. So a speed of 0 gives
/// stability alone. Bodies with many contacts with others are stiffer. Throws invalid_argument for
/// a speed that is negative or not finite.
template <class Scenario>
[[nodiscard]] real critical_dt(world<Scenario>& w,
                               real impact_speed) requires(Scenario::contact_law::soft) {
  w.require_all_ranks("critical_dt");
  if (!(impact_speed >= 0) || !std::isfinite(impact_speed))
    detail::fail<std::invalid_argument>(
        "the impact speed of critical_dt must be finite and not negative, but is {}: give the "
        "largest relative speed at which bodies meet",
        impact_speed);
  return detail::critical_step(w, detail::measure_soft_scales(w), impact_speed);
}
/// Collective: the critical time step of a soft scenario for the impact speed that present motion
/// and gravity make possible: twice the largest speed of a body, plus the largest of a servo or a
/// driven body, plus that of a fall from the highest body to the lowest point of any, or onto a
/// plane. If bodies become faster later, or faster ones are added, pass the speed as an argument.
template <class Scenario>
[[nodiscard]] real critical_dt(world<Scenario>& w) requires(Scenario::contact_law::soft) {
  w.require_all_ranks("critical_dt");
  const auto scales = detail::measure_soft_scales(w);
  return detail::critical_step(w, scales, scales.speed);
}

}  // namespace talus
