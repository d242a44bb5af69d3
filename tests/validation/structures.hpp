#pragma once
// Structures that stand or fall by a closed form: overhanging blocks, leaning cards, the
// semicircular arch of wedges.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <talus/parallel/grid.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/frame.hpp>

#include "record.hpp"
#include "track.hpp"

namespace talus::validation {

using blocks =
    scenario<bodies<box, convex_polyhedron, plane>, decomposition<grid<dynamic, dynamic>>>;
using world_type = world<blocks>;

constexpr real g = 9.81, dt = 1.0 / 240, degree = pi / 180;

inline tracks watch(int ranks, real time, const std::function<void(world_type&)>& set_up,
                    real step = dt) {
  return follow<blocks>(ranks, step, static_cast<std::size_t>(std::lround(time / step)), set_up);
}
/// Structures within a hundredth of falling need accurate impulses from the first step on. On one
/// rank the default settings provide them; between ranks a tolerance is set.
inline void need_accuracy(world_type& w) {
  if (w.ranks() == 1) return;
  w.solver().tolerance = 1e-7;
  w.solver().max_iterations = 300;
}
inline std::string on(int ranks) { return ranks == 1 ? ", 1 rank" : ", 4 ranks"; }

/// Largest distance of a body from its start, at the end.
inline real moved(const tracks& all) {
  real most = 0;
  for (const auto& way : all)
    most = std::max(most, (way.back().position - way.front().position).norm());
  return most;
}
/// Holds if the structure clearly stands or falls as it should: either nothing moves, or all falls.
inline void check_stands(const std::string& test, const std::string& what, bool should,
                         const tracks& all, real size) {
  const real part = moved(all) / size;
  MESSAGE(test, ", ", what, ": moved ", part, " of its size");
  check_holds(test, what, should, part < 0.01);
  if (!should) CHECK(part > 0.1);
}

inline quat about_y(real angle) { return rotation(vec3::UnitY(), angle); }

/// Blocks 1 x 0.6 x 0.25 over the edge of a table, which ends at x = 0: the k-th from the top is
/// shifted by part / (2 k) relative to the block below it.
inline void overhang(world_type& w, int n, real part) {
  need_accuracy(w);
  const auto m = w.material({.friction = 0.5});
  w.gravity({0, 0, -g});
  w.global([&](auto& s) { s.add(box{{8, 8, 1}}, m, vec3(-4, 0, -0.5)); });
  real end = 0;
  for (int k = n; k >= 1; --k) {
    end += part / (2 * k);
    w.add_if_local(
        body{.shape = box{{1, 0.6, 0.25}}, .position = {end - 0.5, 0, 0.25 * (n - k) + 0.125}});
  }
}

/// Two cards that lean on each other, `alpha` off the vertical; rough on each other.
struct cards {
  static constexpr real length = 1, width = 0.6, thickness = 0.001;

  /// Of the floor, at which they slide: half the horizontal part of the lean, for this thickness.
  static real critical(real alpha) { return 0.5 * (std::tan(alpha) - thickness / length); }

  static void add(world_type& w, const vec3& foot, real alpha, material_id m) {
    const real c = std::cos(alpha), s = std::sin(alpha);
    for (const real side : {-1.0, 1.0}) {
      const vec3 along{-side * s, 0, c}, inner{side * c, 0, s};
      // Its inner side runs from the floor to the middle.
      const vec3 low = foot + vec3(side * length * s, 0, 0);
      w.add_if_local(body{.shape = box{{thickness, width, length}},
                          .position = low + 0.5 * length * along + 0.5 * thickness * inner,
                          .material = m,
                          .orientation = about_y(-side * alpha)});
    }
  }
  static void pair(world_type& w, real alpha, real floor_friction) {
    const auto m = w.material({.friction = 1}), floor = w.material({});
    w.material_pair(m, floor, {.friction = floor_friction, .dynamic_friction = floor_friction});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, floor); });
    add(w, {0, 0, 0}, alpha, m);
  }
  /// Two pairs, a card across them, a third pair on it.
  static void house(world_type& w, real alpha, real friction) {
    const auto m = w.material({.friction = friction});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, m); });
    const real high = length * std::cos(alpha), half = length * std::sin(alpha);
    const real gap = 0.05;
    for (const real side : {-1.0, 1.0}) add(w, {side * (half + gap), 0, 0}, alpha, m);
    const real top = high + thickness * std::sin(alpha);
    w.add_if_local(body{.shape = box{{4 * half, width, thickness}},
                        .position = {0, 0, top + 0.5 * thickness},
                        .material = m});
    add(w, {0, 0, top + thickness}, alpha, m);
  }
};

/// Semicircular arch with centre line of radius 1 on the floor at this y, joints radial.
inline void add_arch(world_type& w, material_id m, int n, real thickness, real y0) {
  for (int k = 0; k < n; ++k) {
    std::vector<vec3> corners;
    for (const int joint : {k, k + 1})
      for (const real r : {1 - thickness / 2, 1 + thickness / 2})
        for (const real y : {y0 - 0.15, y0 + 0.15}) {
          // The two springings are level to the last bit.
          const real angle = pi * joint / n;
          const real z = joint == 0 || joint == n ? 0 : r * std::sin(angle);
          corners.push_back({r * std::cos(angle), y, z});
        }
    const convex_polyhedron wedge(corners);
    const pose at = placed(wedge);
    w.add_if_local(body{
        .shape = wedge, .position = at.position, .material = m, .orientation = at.orientation});
  }
}

inline void arch(world_type& w, int n, real thickness, real friction) {
  need_accuracy(w);
  const auto m = w.material({.friction = friction});
  w.gravity({0, 0, -g});
  w.global([&](auto& s) { s.add(plane{}, m); });
  add_arch(w, m, n, thickness, 0);
}

/// The arch at 1.02 and 0.98 of its least thickness (closed form).
inline void check_arches(int ranks) {
  for (const auto& [n, least] : {std::pair{18, 0.105964}, std::pair{20, 0.10746}})
    for (const real part : {0.98, 1.02})
      check_stands("arch" + on(ranks), fmt::format("{} wedges at {:.2f}", n, part), part > 1,
                   watch(ranks, part > 1 ? 3 : 6, [&](auto& w) { arch(w, n, part * least, 0.7); }),
                   1);
}
/// `count` arches of 20 wedges, side by side around y = 0 at this distance of their centres.
inline tracks arches(int ranks, int count, real thickness, real distance) {
  return watch(ranks, 3, [&](auto& w) {
    need_accuracy(w);
    const auto m = w.material({.friction = 0.7});
    w.gravity({0, 0, -g});
    w.global([&](auto& s) { s.add(plane{}, m); });
    for (int k = 0; k < count; ++k)
      add_arch(w, m, 20, thickness, distance * (k - 0.5 * (count - 1)));
  });
}

/// Speeds of the wave through thirty dominoes of height `unit`, thickness 0.1, width 0.5, distance
/// of the centres 0.4, mu 0.2, the first of which is pushed: over five dominoes each, after the
/// first ten.
inline std::vector<real> speeds_of_wave(int ranks, real unit, real step) {
  constexpr int count = 30;

  const auto all = watch(
      ranks, 4.2 * std::sqrt(unit),
      [&](auto& w) {
        const auto m = w.material({.friction = 0.2});
        w.gravity({0, 0, -g});
        w.global([&](auto& s) { s.add(plane{}, m); });
        for (int k = 0; k < count; ++k)
          w.add_if_local(
              body{.shape = box{unit * vec3(0.1, 0.5, 1)},
                   .position = unit * vec3(0.4 * (k - count / 2), 0, 0.5),
                   .angular_velocity = k == 0 ? vec3(0, 3 / std::sqrt(unit), 0) : vec3(0, 0, 0)});
      },
      step);
  // The time at which each has rotated by a tenth of a radian.
  std::vector<real> when;
  for (const auto& way : all)
    for (std::size_t k = 1; k < way.size(); ++k) {
      const auto tilt = [&](std::size_t i) {
        return std::asin((way[i].orientation * vec3::UnitZ())[0]);
      };
      if (tilt(k) < 0.1) continue;
      when.push_back(step * (real(k) - (tilt(k) - 0.1) / (tilt(k) - tilt(k - 1))));
      break;
    }
  REQUIRE(when.size() == count);
  std::vector<real> speeds;  // over five dominoes each, after the first ten
  for (int k = 10; k + 5 < count; k += 5)
    speeds.push_back(unit * 0.4 * 5 / (when[std::size_t(k + 5)] - when[std::size_t(k)]));
  return speeds;
}
inline real mean_of(const std::vector<real>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / real(values.size());
}
inline void check_steady(const std::string& test, const std::vector<real>& speeds) {
  const auto [slow, fast] = std::minmax_element(speeds.begin(), speeds.end());
  MESSAGE(test, ": speed of the wave over sqrt(g h) ", mean_of(speeds) / std::sqrt(g));
  check_error(test, "spread of the speed after the first ten", (*fast - *slow) / mean_of(speeds),
              0.05);
}

/// Harmonic overhang: blocks stand at 0.99 of L/2 (1 + 1/2 + ... + 1/n) and fall at 1.01 of it.
inline void check_overhang(int ranks) {
  for (int n = 1; n <= 5; ++n)
    for (const real part : {0.99, 1.01})
      check_stands("overhang" + on(ranks),
                   std::to_string(n) + " blocks at " + fmt::format("{:.2f}", part), part < 1,
                   watch(
                       ranks, part < 1 ? 3 : 5, [&](auto& w) { overhang(w, n, part); }),
                   1);
}

}  // namespace talus::validation
