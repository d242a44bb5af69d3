#pragma once
// Queries by brute force: every body of every rank, and every image of it, one by one.
#include <doctest/doctest.h>

#include <algorithm>
#include <span>
#include <talus/queries.hpp>
#include <vector>

#include "../generator.hpp"

namespace talus {

/// Calls f(shape, pose, hit) for each own body of a rank, or each global one, with what names it.
template <class World, class F>
void each_body_here(const World& w, bool global, F&& f) {
  int kind = 0;
  detail::view_of(w).each_shape([&](const auto& b) {
    const auto& store = global ? b.global : b.movable;
    for (std::size_t i = 0; i < (global ? store.size() : store.locals); ++i) {
      query_hit of;
      of.id = store.id[i], of.kind = kind, of.global = global;
      f(store.shape[i], store.pose(i), of);
    }
    ++kind;
  });
}
/// Collective: the lists of all ranks behind each other, the global one once.
template <class World>
std::vector<query_hit> gathered(World& w, const std::vector<query_hit>& own,
                                const std::vector<query_hit>& of_global) {
  detail::byte_buffer mine;
  detail::byte_writer(mine).put(std::span<const query_hit>(own));
  std::vector<query_hit> all = of_global;
  for (const auto& theirs : w.link().gather_all(mine)) {
    detail::byte_reader in(theirs);
    for (const query_hit& hit : in.template get_all<query_hit>()) all.push_back(hit);
  }
  std::sort(all.begin(), all.end());
  return all;
}
/// Collective: what `look(shape, pose, shift)` finds of all bodies and their images up to `around`
/// periods away, sorted; alike on all ranks.
template <class World, class Look>
std::vector<query_hit> by_brute_force(World& w, int around, Look&& look) {
  std::vector<query_hit> lists[2];
  vec3 period(0, 0, 0);
  if constexpr (detail::world_state<typename World::scenario_type>::periodic)
    period = w.periodic_space().period();
  for (const bool global : {false, true})
    each_body_here(w, global, [&](const auto& shape, const pose& at, query_hit of) {
      for (int x = -around; x <= around; ++x)
        for (int y = -around; y <= around; ++y)
          for (int z = -around; z <= around; ++z) {
            const vec3 shift(x * period[0], y * period[1], z * period[2]);
            if ((x != 0 && period[0] == 0) || (y != 0 && period[1] == 0) ||
                (z != 0 && period[2] == 0) || (global && (x != 0 || y != 0 || z != 0)))
              continue;
            const detail::surface_hit hit = look(shape, at, shift);
            if (!hit.found()) continue;
            of.distance = hit.distance, of.point = hit.point + shift, of.normal = hit.normal;
            of.inside = hit.inside;
            lists[global].push_back(of);
          }
    });
  return gathered(w, lists[0], lists[1]);
}
inline void check_alike(const query_hit& x, const query_hit& y, double tolerance) {
  REQUIRE(bool(x) == bool(y));
  if (!x) return;
  CHECK(x.id == y.id);
  CHECK(x.kind == y.kind);
  CHECK(x.global == y.global);
  CHECK(x.inside == y.inside);
  CHECK(std::abs(x.distance - y.distance) <= tolerance);
  CHECK(vec3(x.point - y.point).norm() <= 10 * tolerance);
  CHECK(vec3(x.normal - y.normal).norm() <= 1e-6);
}
inline void check_alike(const std::vector<query_hit>& x, const std::vector<query_hit>& y,
                        double tolerance) {
  REQUIRE(x.size() == y.size());
  for (std::size_t k = 0; k < x.size(); ++k) check_alike(x[k], y[k], tolerance);
}
/// The part of a list for this rank: those whose number is that of the rank, over the ranks.
template <class World, class T>
std::vector<T> share_of(const World& w, const std::vector<T>& all) {
  std::vector<T> mine;
  for (std::size_t k = static_cast<std::size_t>(w.rank()); k < all.size();
       k += static_cast<std::size_t>(w.ranks()))
    mine.push_back(all[k]);
  return mine;
}
/// Number k of all is question k / ranks of rank k % ranks.
template <class World>
bool is_mine(const World& w, std::size_t k, std::size_t& number) {
  number = k / static_cast<std::size_t>(w.ranks());
  return k % static_cast<std::size_t>(w.ranks()) == static_cast<std::size_t>(w.rank());
}

}  // namespace talus
