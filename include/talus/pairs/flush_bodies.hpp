#pragma once
// Finds the fixed bodies that touch each other, anew when one of them has changed.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/detect/flush.hpp"
#include "talus/state/kinematic_bodies.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Calls f(bodies of a shape, their store, whether it is global, index) for the bodies that are
/// fixed and may be flush with others.
template <class Scenario, class F>
void each_flush_body(const world_state<Scenario>& s, F&& f) {
  s.each_shape([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (is_solid_beside<shape>) {
      for (std::size_t i = 0; i < b.global.size(); ++i) f(b, b.global, true, i);
      if constexpr (shape::finite)
        for (std::size_t i = 0; i < b.movable.size(); ++i)
          if (b.movable.inverse_mass[i] == 0) f(b, b.movable, false, i);
    }
  });
}
/// Of a body that is driven: how far it may move until neighbours are found anew.
[[nodiscard]] inline real flush_skin(real radius) { return real(0.05) * radius; }

template <class Scenario>
[[nodiscard]] bool flush_bodies_hold(const world_state<Scenario>& s) {
  const auto& f = s.flush;
  bool hold = f.known;
  s.each_shape([&](const auto& b) { hold = hold && !b.globals_changed; });
  if (!hold) return false;
  std::size_t k = 0;
  s.each_shape([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (is_solid_beside<shape>) {
      if constexpr (world_state<Scenario>::drives)
        for (std::size_t n = k; hold && n < k + b.global.size(); ++n) {
          const flush_body& one = f.all[n];
          if (!one.driven) continue;
          const pose now = b.global.pose(one.index);
          const quat turn = now.orientation * one.at.orientation.conjugate();
          hold = (now.position - one.at.position).norm() +
                     2 * vec3(turn.x(), turn.y(), turn.z()).norm() * one.radius <=
                 flush_skin(one.radius);
        }
      k += b.global.size();
      if constexpr (shape::finite)
        for (std::size_t i = 0; hold && i < b.movable.size(); ++i) {
          if (b.movable.inverse_mass[i] != 0) continue;
          hold = k < f.all.size() && !f.all[k].global && f.all[k].index == i &&
                 f.all[k].id == b.movable.id[i] && f.all[k].at.position == b.movable.position[i] &&
                 f.all[k].at.orientation.coeffs() == b.movable.pose(i).orientation.coeffs();
          ++k;
        }
    }
  });
  return hold && k == f.all.size();
}

/// Removes the pairs of a body and a plane that it is clear of.
template <class Scenario, class Pairs>
void drop_clear_of_planes(const world_state<Scenario>& s, Pairs& pairs) {
  s.each_shape([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (is_half_space<shape>) {
      constexpr std::size_t kind = index_of<typename Scenario::shapes, shape>;
      std::size_t kept = 0;
      for (const auto& pair : pairs) {
        const flush_body &x = s.flush.all[pair.first], &y = s.flush.all[pair.second];
        const flush_body &half = x.shape == kind ? x : y, &other = x.shape == kind ? y : x;
        if (half.shape == kind && !half.driven) {
          const shape& p = b.global.shape[half.index];
          const vec3 middle = real(0.5) * (other.lower + other.upper),
                     reach = real(0.5) * (other.upper - other.lower);
          if (p.distance(middle) > reach.dot(p.unit_normal().cwiseAbs())) continue;
        }
        pairs[kept++] = pair;
      }
      pairs.resize(kept);
    }
  });
}

template <class Scenario>
void find_flush_bodies(world_state<Scenario>& s) {
  constexpr std::size_t shapes = Scenario::shapes::size;
  auto& f = s.flush;
  f.all.clear();
  f.numbers.assign(2 * shapes, {});
  constexpr real infinity = std::numeric_limits<real>::infinity();
  each_flush_body(s, [&](const auto& b, const auto& store, bool global, std::size_t i) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    constexpr std::size_t kind = index_of<typename Scenario::shapes, shape>;
    flush_body one{.shape = kind,
                   .index = static_cast<std::uint32_t>(i),
                   .global = global,
                   .id = store.id[i],
                   .at = store.pose(i)};
    if constexpr (world_state<Scenario>::drives)
      one.driven = global && driven_at<shape>(s, i) != nullptr;
    if constexpr (shape::finite) {
      one.radius = store.shape[i].bounding_radius();
      real more = flush_part * one.radius;
      if (one.driven) more += flush_skin(one.radius);
      const vec3 reach = store.shape[i].half_extents(one.at) + vec3(more, more, more);
      one.lower = one.at.position - reach, one.upper = one.at.position + reach;
    } else {
      one.lower = vec3(-infinity, -infinity, -infinity), one.upper = -one.lower;
    }
    auto& numbers = f.numbers[2 * kind + !global];
    numbers.resize(std::max(numbers.size(), i + 1), -1);
    numbers[i] = static_cast<std::int32_t>(f.all.size());
    f.all.push_back(one);
  });
  // Of two bodies whose boxes overlap, a sweep along x (planes come first).
  plain_vector<std::uint32_t> order, active;
  for (std::uint32_t k = 0; k < f.all.size(); ++k) order.push_back(k);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const real x = f.all[a].lower[0], y = f.all[b].lower[0];
    return x != y ? x < y : a < b;
  });
  plain_vector<plain_pair<std::uint32_t, std::uint32_t>> touching;
  for (const std::uint32_t k : order) {
    const flush_body& one = f.all[k];
    std::size_t kept = 0;
    for (const std::uint32_t other : active) {
      const flush_body& x = f.all[other];
      if (x.upper[0] < one.lower[0]) continue;
      active[kept++] = other;
      if (x.upper[1] < one.lower[1] || one.upper[1] < x.lower[1] || x.upper[2] < one.lower[2] ||
          one.upper[2] < x.lower[2])
        continue;
      if (one.radius == 0 && x.radius == 0) continue;
      touching.push_back({k, other}), touching.push_back({other, k});
    }
    active.resize(kept);
    active.push_back(k);
  }
  drop_clear_of_planes(s, touching);
  std::sort(touching.begin(), touching.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  });
  f.first.clear(), f.near.clear();
  for (std::uint32_t k = 0; k < f.all.size(); ++k) {
    f.first.push_back(static_cast<std::uint32_t>(f.near.size()));
    while (f.near.size() < touching.size() && touching[f.near.size()].first == k)
      f.near.push_back(touching[f.near.size()].second);
  }
  f.first.push_back(static_cast<std::uint32_t>(f.near.size()));
  f.known = true;
}
/// Before contacts are found.
template <class Scenario>
void update_flush_bodies(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::may_be_flush)
    if (!flush_bodies_hold(s)) find_flush_bodies(s);
}

}  // namespace talus::detail
