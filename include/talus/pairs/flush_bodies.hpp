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
/// How far a driven body with this bounding radius may move before its neighbours are searched
/// again.
[[nodiscard]] inline real flush_skin(real radius) { return real(0.05) * radius; }

/// The fixed body of a shape with this id and pose among those that were found, or -1.
template <class Store>
[[nodiscard]] std::int32_t found_before(const flush_bodies& f, std::size_t kind, const Store& store,
                                        std::size_t i) {
  const pose now = store.pose(i);
  const auto* at = std::lower_bound(f.of_ids.begin(), f.of_ids.end(), store.id[i],
                                    [](const auto& x, system_id id) { return x.first < id; });
  for (; at != f.of_ids.end() && at->first == store.id[i]; ++at)
    if (const flush_body& one = f.all[at->second];
        one.shape == kind && one.at.position == now.position &&
        one.at.orientation.coeffs() == now.orientation.coeffs())
      return static_cast<std::int32_t>(at->second);
  return -1;
}
/// Whether the bodies are still those that were found; fixed ones may have other indices now. (A
/// change of global bodies is noted in prepare_detection().)
template <class Scenario>
[[nodiscard]] bool flush_bodies_hold(world_state<Scenario>& s) {
  auto& f = s.flush;
  bool hold = f.known;
  std::size_t fixed = 0;
  s.each_shape([&](const auto& b) {
    using shape = typename std::remove_cvref_t<decltype(b)>::shape_type;
    if constexpr (is_solid_beside<shape>) {
      constexpr std::size_t kind = index_of<typename Scenario::shapes, shape>;
      if constexpr (world_state<Scenario>::drives)
        for (std::size_t i = 0; hold && i < b.global.size(); ++i) {
          const flush_body& one = f.all[static_cast<std::size_t>(f.number_of(kind, true, i))];
          hold = one.driven == (driven_at<shape>(s, i) != nullptr);
          if (!hold || !one.driven || !shape::finite) continue;
          const pose now = b.global.pose(i);
          const quat turn = now.orientation * one.at.orientation.conjugate();
          hold = (now.position - one.at.position).norm() +
                     2 * vec3(turn.x(), turn.y(), turn.z()).norm() * one.radius <=
                 flush_skin(one.radius);
        }
      if constexpr (shape::finite) {
        auto& numbers = f.numbers[2 * kind + 1];
        for (std::size_t i = 0; hold && i < b.movable.size(); ++i) {
          if (b.movable.inverse_mass[i] != 0) continue;
          ++fixed;
          const std::int32_t k = found_before(f, kind, b.movable, i);
          hold = k >= 0;
          if (!hold) continue;
          numbers.resize(std::max(numbers.size(), i + 1), -1);
          numbers[i] = k;
          f.all[static_cast<std::size_t>(k)].index = static_cast<std::uint32_t>(i);
        }
      }
    }
  });
  return hold && fixed == f.of_ids.size();
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

/// The axis along which bodies that are finite begin furthest apart.
[[nodiscard]] inline int widest_axis(const flush_bodies& f, const std::uint32_t* from,
                                     const std::uint32_t* to) {
  constexpr real infinity = std::numeric_limits<real>::infinity();
  vec3 least(infinity, infinity, infinity), most = -least;
  for (; from != to; ++from)
    if (const flush_body& one = f.all[*from]; one.radius > 0)
      least = least.cwiseMin(one.lower), most = most.cwiseMax(one.lower);
  const vec3 spread = most - least;
  int axis = 0;
  for (const int k : {1, 2})
    if (spread[k] > spread[axis]) axis = k;
  return axis;
}
/// Planes come first.
struct begins_before {
  const flush_bodies& f;
  int axis;
  bool operator()(std::uint32_t a, std::uint32_t b) const {
    const real x = f.all[a].lower[axis], y = f.all[b].lower[axis];
    return x != y ? x < y : a < b;
  }
};

template <class Scenario>
void find_flush_bodies(world_state<Scenario>& s) {
  constexpr std::size_t shapes = Scenario::shapes::size;
  auto& f = s.flush;
  f.all.clear(), f.of_ids.clear();
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
    if (!global) f.of_ids.push_back({one.id, static_cast<std::uint32_t>(f.all.size())});
    f.all.push_back(one);
  });
  std::sort(f.of_ids.begin(), f.of_ids.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  });
  // Sweep and prune along an axis finds the pairs of bodies whose boxes overlap (planes come
  // first).
  plain_vector<std::uint32_t> order, active;
  for (std::uint32_t k = 0; k < f.all.size(); ++k) order.push_back(k);
  const int axis = widest_axis(f, order.begin(), order.end());
  std::sort(order.begin(), order.end(), begins_before{f, axis});
  plain_vector<plain_pair<std::uint32_t, std::uint32_t>> touching;
  for (const std::uint32_t k : order) {
    const flush_body& one = f.all[k];
    std::size_t kept = 0;
    for (const std::uint32_t other : active) {
      const flush_body& x = f.all[other];
      if (x.upper[axis] < one.lower[axis]) continue;
      active[kept++] = other;
      if ((x.upper - one.lower).minCoeff() < 0 || (one.upper - x.lower).minCoeff() < 0 ||
          (one.radius == 0 && x.radius == 0))
        continue;
      touching.push_back({k, other}), touching.push_back({other, k});
    }
    active.resize(kept);
    active.push_back(k);
  }
  drop_clear_of_planes(s, touching);
  std::sort(touching.begin(), touching.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  });
  f.ranges.clear(), f.near.clear();
  for (std::uint32_t k = 0; k < f.all.size(); ++k) {
    const auto first = static_cast<std::uint32_t>(f.near.size());
    while (f.near.size() < touching.size() && touching[f.near.size()].first == k)
      f.near.push_back(touching[f.near.size()].second);
    std::uint32_t *from = f.near.data() + first, *to = f.near.data() + f.near.size();
    const int along = widest_axis(f, from, to);
    std::sort(from, to, begins_before{f, along});
    std::uint32_t sorted = first;
    while (sorted < f.near.size() && f.all[f.near[sorted]].radius == 0) ++sorted;
    f.ranges.push_back({first, sorted, along});
  }
  const auto size = static_cast<std::uint32_t>(f.near.size());
  f.ranges.push_back({size, size, 0});
  f.furthest.resize(size);
  for (std::size_t k = 0; k < f.all.size(); ++k) {
    const auto [first, sorted, along] = f.ranges[k];
    for (std::uint32_t n = sorted; n < f.ranges[k + 1].first; ++n) {
      const real upper = f.all[f.near[n]].upper[along];
      f.furthest[n] = n > sorted ? std::max(f.furthest[n - 1], upper) : upper;
    }
  }
  f.known = true;
}
/// Before contacts are found, and after prepare_detection() or kept pairs.
template <class Scenario>
void update_flush_bodies(world_state<Scenario>& s) {
  if constexpr (world_state<Scenario>::may_be_flush)
    if (!flush_bodies_hold(s)) find_flush_bodies(s);
}

}  // namespace talus::detail
