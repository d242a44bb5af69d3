#pragma once
// Overlaps of bodies: from positions by geometry alone, independent of the solver.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "talus/core/exact_sum.hpp"
#include "talus/core/id.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/detect/hash_grid.hpp"
#include "talus/detect/narrow.hpp"
#include "talus/detect/thickness.hpp"
#include "talus/pairs/filtered_pairs.hpp"
#include "talus/parallel/exact_reduction.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// Overlaps of the present state; lengths are over the mean bounding radius of the movable bodies.
struct penetration {
  double mean = 0;  ///< over the points of negative gap
  /// the deepest overlap over the mean radius
  double max = 0;
  double gap_mean_loaded =
      0;  ///< mean |gap| over the points that carried an impulse (soft: overlap)
  std::uint64_t touching = 0;  ///< points with a gap of at most a thousandth of the mean radius
  double mean_radius = 0;      ///< a length
  /// The largest overlap over the radius (half the thickness) of the thinner body of its pair.
  double deepest = 0;
};

namespace detail {

/// The pair of bodies with the largest overlap relative to their size.
struct deepest_pair {
  double part = 0;   ///< depth over half the thickness of the thinner one
  double depth = 0;  ///< a length
  vec3 at{0, 0, 0};  ///< centre of the first, which this rank owns
  system_id a = no_id, b = no_id;
  const char *shape_a = "", *shape_b = "";
  vec3 normal{0, 0, 0};  ///< of the second if it is a plane, else 0
};

/// Sums over the contact points of one rank; each point is counted on one rank only.
struct gap_sums {
  exact_sum overlap, loaded_gap;
  double deepest = 0;
  std::array<std::uint64_t, 3> counts{};  ///< of points: overlapping, loaded, touching
  deepest_pair worst;

  void add(real gap, real radius, bool carries) {
    if (gap < 0) overlap += -gap, ++counts[0];
    deepest = std::max(deepest, -gap);
    if (gap <= 1e-3 * radius) ++counts[2];
    if (carries) loaded_gap += std::abs(gap), ++counts[1];
  }
};

/// Pairs of bodies with joints, which have no contacts: the lower id first; sorted.
using jointed_pairs = plain_vector<plain_pair<system_id, system_id>>;

/// The pairs of bodies of all joints that this rank holds.
template <class Scenario>
[[nodiscard, gnu::cold]] jointed_pairs pairs_with_joints(const world_state<Scenario>& s) {
  jointed_pairs pairs;
  if constexpr (world_state<Scenario>::has_joints) {
    s.joints.each_kind([&](const auto& of_kind) {
      for (const auto& r : of_kind.records)
        pairs.push_back(value_of(r.key.a) < value_of(r.key.b) ? plain_pair{r.key.a, r.key.b}
                                                              : plain_pair{r.key.b, r.key.a});
    });
    sort_values(pairs);
  }
  return pairs;
}

/// Adds all pairs of a body owned here with a body of `others` that may touch. Of a pair
/// known to two ranks, the one that owns the first body (by shape, then by id) counts.
template <class Scenario, class Store, class Others>
[[gnu::cold]] void add_gaps(gap_sums& sums, const world_state<Scenario>& s, const Store& own,
                            const Others& others, bool others_move, bool same_shape, real radius,
                            const jointed_pairs& joined) {
  const auto& history = s.history;
  using shape = typename Store::shape_type;
  using other = typename Others::shape_type;
  constexpr bool soft = Scenario::contact_law::soft;
  const real margin = 0.02 * radius;
  const auto pair = [&](std::size_t i, std::size_t j) {
    const bool own_i = i < own.locals, own_j = others_move && j < others.locals;
    if (!own_i && !own_j) return;
    bool forward = true;
    if (others_move && same_shape) forward = own.id[i] < others.id[j];
    if (others_move && !(forward ? own_i : own_j)) return;
    if (own.fixed(i) && (!others_move || others.fixed(j))) return;
    if (!joined.empty()) {
      const bool in_order = value_of(own.id[i]) < value_of(others.id[j]);
      const plain_pair both =
          in_order ? plain_pair{own.id[i], others.id[j]} : plain_pair{others.id[j], own.id[i]};
      if (std::binary_search(joined.begin(), joined.end(), both)) return;
    }
    if constexpr (world_state<Scenario>::filters)
      if (!may_touch(s, own, i, others, j)) return;
    const real size = std::min(half_thickness(own.shape[i]), half_thickness(others.shape[j]));
    const auto count = [&](const contact_geometry& g, const contact_key& key) {
      if (-g.gap > sums.worst.part * size) {
        sums.worst = {-g.gap / size, -g.gap,      own.position[i], own.id[i],
                      others.id[j],  shape::name, other::name,     {0, 0, 0}};
        if constexpr (!other::finite) sums.worst.normal = g.normal;
        if (!own_i) {
          sums.worst.at = others.position[j];
          std::swap(sums.worst.a, sums.worst.b), std::swap(sums.worst.shape_a, sums.worst.shape_b);
        }
      }
      if constexpr (soft) {
        sums.add(g.gap, radius, g.gap < 0);
      } else {
        const vec3* impulse = history.find(key);
        sums.add(g.gap, radius, impulse != nullptr && impulse->squaredNorm() > 0);
      }
    };
    if (forward)
      collide_pair(own.shape[i], own.pose(i), others.shape[j], others.pose(j), margin,
                   [&](const contact_geometry& g) {
                     count(g, {own.id[i], others.id[j], g.feature});
                   });
    else
      collide_pair(others.shape[j], others.pose(j), own.shape[i], own.pose(i), margin,
                   [&](const contact_geometry& g) {
                     count(g, {others.id[j], own.id[i], g.feature});
                   });
  };

  if constexpr (other::finite) {
    const auto grid_of = [&](const auto& store) {
      detail::plain_vector<real> reach(store.size());
      for (std::size_t i = 0; i < reach.size(); ++i)
        reach[i] = store.shape[i].bounding_radius() + margin / 2;
      hash_grid grid;
      grid.build(store.position, reach);
      return grid;
    };
    const auto mine = grid_of(own);
    if (same_shape && others_move)
      mine.pairs(pair);
    else
      mine.pairs_with(grid_of(others), pair);
  } else {
    for (std::size_t i = 0; i < own.locals; ++i)
      for (std::size_t j = 0; j < others.size(); ++j) pair(i, j);
  }
}

/// Sums over the gaps of the bodies that this rank knows; `radius` is a length, the mean bounding
/// radius.
template <class Scenario>
[[nodiscard, gnu::cold]] gap_sums measure_gaps(const world_state<Scenario>& s, real radius) {
  gap_sums sums;
  const jointed_pairs joined = pairs_with_joints(s);
  s.each_finite_shape([&](const auto& a) {
    using A = typename std::remove_cvref_t<decltype(a)>::shape_type;
    s.each_shape([&](const auto& b) {
      using B = typename std::remove_cvref_t<decltype(b)>::shape_type;
      using shapes = typename Scenario::shapes;
      constexpr bool same = std::is_same_v<A, B>;
      constexpr bool first = index_of<shapes, A> <= index_of<shapes, B>;
      if constexpr (B::finite && first)
        add_gaps(sums, s, a.movable, b.movable, true, same, radius, joined);
      if (b.global.size() > 0) add_gaps(sums, s, a.movable, b.global, false, same, radius, joined);
    });
  });
  return sums;
}

/// Collective: the mean bounding radius of the bodies that can move, a length; 1 if there is none.
template <class Scenario>
[[nodiscard, gnu::cold]] real mean_radius(world<Scenario>& w) {
  exact_sum radii;
  std::uint64_t count = 0;
  w.for_each_local([&](const auto& b) {
    if (!b.is_fixed()) radii += b.shape().bounding_radius(), ++count;
  });
  sum_exactly(w.link(), radii);
  w.link().reduce(reduction::sum, std::span(&count, 1));
  return count > 0 ? radii.value() / static_cast<real>(count) : 1;
}

}  // namespace detail

/// Collective: measures the overlaps of all bodies. Needs up-to-date shadow copies, as they are
/// after a step or a synchronize().
template <class Scenario>
[[nodiscard, gnu::cold]] penetration measure_penetration(world<Scenario>& w) {
  w.require_all_ranks("measure_penetration");
  const real radius = detail::mean_radius(w);
  detail::gap_sums sums = detail::measure_gaps(detail::view_of(w), radius);
  detail::sum_exactly(w.link(), sums.overlap, sums.loaded_gap);
  w.link().reduce(reduction::sum, std::span<std::uint64_t>(sums.counts));
  w.link().reduce(reduction::max, std::span(&sums.deepest, 1));
  w.link().reduce(reduction::max, std::span(&sums.worst.part, 1));

  penetration p;
  const auto mean = [&](const detail::exact_sum& sum, std::uint64_t count) {
    return count > 0 ? sum.value() / static_cast<real>(count) / radius : 0;
  };
  p.mean = mean(sums.overlap, sums.counts[0]);
  p.max = sums.deepest / radius;
  p.gap_mean_loaded = mean(sums.loaded_gap, sums.counts[1]);
  p.touching = sums.counts[2];
  p.mean_radius = radius;
  p.deepest = sums.worst.part;
  return p;
}

}  // namespace talus
