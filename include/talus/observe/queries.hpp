#pragma once
// Questions about the bodies of all ranks: what a ray or a moving shape meets, what is nearest to a
// point, what a shape would overlap, what is in a region. docs/output.md.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "talus/body/body.hpp"
#include "talus/core/region_check.hpp"
#include "talus/observe/ask_ranks.hpp"
#include "talus/observe/asked_bodies.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// A half-line, or a part of it.
struct ray {
  vec3 from{0, 0, 0};             ///< its start
  vec3 direction{0, 0, -1};       ///< any length but zero
  real length = detail::endless;  ///< from the start, length
  system_id except = no_id;       ///< a body that it passes, such as the one that carries a sensor
};
/// The way of a shape that moves along a straight line without turning.
struct shape_path {
  vec3 from{0, 0, 0};             ///< its centre of mass at the start
  vec3 direction{0, 0, -1};       ///< any length but zero
  real length = detail::endless;  ///< of the way
  quat orientation{1, 0, 0, 0};   ///< a unit quaternion
  system_id except = no_id;       ///< a body that it passes
};

/// The handle of the body that was hit, empty if it is of another shape. `world[handle]` is the
/// body, on ranks that know it.
template <class Shape, class Scenario>
[[nodiscard]] std::optional<handle<Shape>> handle_of(const world<Scenario>&, const query_hit& hit) {
  if (hit && hit.kind == static_cast<int>(detail::index_of<typename Scenario::shapes, Shape>))
    return handle<Shape>{hit.id};
  return std::nullopt;
}
/// The name of the shape of a hit, such as "sphere"; empty for none.
template <class Scenario>
[[nodiscard]] const char* shape_name(const world<Scenario>& w, const query_hit& hit) {
  const char* name = "";
  int kind = 0;
  detail::view_of(w).each_shape([&](const auto& b) {
    if (kind++ == hit.kind) name = std::remove_cvref_t<decltype(b)>::shape_type::name;
  });
  return name;
}

namespace detail {

// What is wrong with a question, a filter or a shape; empty if nothing is.
template <class Scenario>
[[nodiscard, gnu::cold]] std::string fault_of(const world<Scenario>& w, const char* what,
                                              std::size_t number, const vec3& from,
                                              const vec3& direction, real length) {
  if (!finite(from))
    return compose("question {} of rank {} to {} starts at {}: give a finite place", number,
                   w.rank(), what, from);
  if (!finite(direction) || max_norm(direction) == 0)
    return compose(
        "question {} of rank {} to {} has the direction {}: give one that is finite and "
        "not zero",
        number, w.rank(), what, direction);
  if (!(length >= 0))
    return compose("question {} of rank {} to {} has the length {}: give one of 0 or more", number,
                   w.rank(), what, length);
  if constexpr (world_state<Scenario>::periodic) {
    constexpr real most = 1e6;
    const vec3 period = view_of(w).own.box().period(), way = unit(direction);
    for (int k = 0; k < 3; ++k)
      if (period[k] > 0 && way[k] != 0 && !(std::abs(way[k]) * length <= most * period[k]))
        return compose(
            "question {} of rank {} to {} goes {} far in the direction {}, over more than {} "
            "periods "
            "of {}: give a .length, since a way in periodic space does not end",
            number, w.rank(), what, length, direction, most, period[k]);
  }
  return {};
}
template <class Scenario>
[[nodiscard, gnu::cold]] std::string fault_of(const world<Scenario>&, const char* what,
                                              const query_filter& filter) {
  if (!Scenario::template has_feature<contact_filters> && filter.groups != ~std::uint32_t{0})
    return compose(
        "{} has a filter with .groups = {}, and the bodies of this scenario have no "
        "groups: add contact_filters to its features<...>",
        what, filter.groups);
  return {};
}
template <class Shape>
[[nodiscard, gnu::cold]] std::string fault_of(const Shape& shape) {
  try {
    shape.validate();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return {};
}
[[nodiscard, gnu::cold]] inline std::string fault_of(int rank, const char* what, std::size_t number,
                                                     const quat& turn) {
  if (std::abs(turn.norm() - 1) <= 1e-6) return {};
  return compose(
      "question {} of rank {} to {} has an orientation of norm {}: give a unit quaternion", number,
      rank, what, turn.norm());
}

template <class Shape>
concept movable_query = concepts::finite_shape<Shape> && !requires(const Shape& s) {
  s.tree();
};
template <class Shape>
consteval bool require_query_shape() {
  static_assert(movable_query<Shape>,
                "a shape that moves, or is to be placed, has a volume: pass a sphere, a box or "
                "another finite shape, but neither a plane nor a triangle_mesh");
  return movable_query<Shape>;
}

template <query_kind What, class Scenario>
[[nodiscard]] std::vector<std::vector<query_hit>> ask_rays(world<Scenario>& w, const char* what,
                                                           std::span<const ray> rays,
                                                           const query_filter& filter) {
  std::string fault = fault_of(w, what, filter);
  std::vector<question> all;
  for (const ray& r : rays) {
    const std::size_t n = all.size();
    if (fault.empty()) fault = fault_of(w, what, n, r.from, r.direction, r.length);
    all.push_back({r.from,
                   {1, 0, 0, 0},
                   unit(r.direction),
                   r.length,
                   r.except,
                   static_cast<std::uint32_t>(n)});
  }
  return ask<What>(w, what, filter, point_probe{}, all, fault);
}
template <query_kind What, class Scenario, class Shape>
[[nodiscard]] std::vector<std::vector<query_hit>> ask_paths(world<Scenario>& w, const char* what,
                                                            const Shape& shape,
                                                            std::span<const shape_path> paths,
                                                            const query_filter& filter) {
  if constexpr (require_query_shape<Shape>()) {
    std::string fault = fault_of(w, what, filter);
    if (fault.empty()) fault = fault_of(shape);
    std::vector<question> all;
    for (const shape_path& p : paths) {
      const std::size_t n = all.size();
      if (fault.empty()) fault = fault_of(w, what, n, p.from, p.direction, p.length);
      if (fault.empty()) fault = fault_of(w.rank(), what, n, p.orientation);
      all.push_back({p.from, p.orientation, unit(p.direction), p.length, p.except,
                     static_cast<std::uint32_t>(n)});
    }
    return ask<What>(w, what, filter, shape_probe<Shape>{shape}, all, fault);
  }
  return {};
}
[[nodiscard]] inline std::vector<query_hit> first_of_each(
    const std::vector<std::vector<query_hit>>& all) {
  std::vector<query_hit> first;
  for (const auto& hits : all) first.push_back(hits.empty() ? query_hit{} : hits.front());
  return first;
}

}  // namespace detail

/// Collective: the first body on each ray. Each rank asks with its own rays (or none) and gets
/// their hits, in their order; those without a body are false. The hits are exact to rounding, of
/// shapes of one's own to 1e-9 of their sizes. One that starts in a body meets it at the start. A
/// surface of triangles is met from either side, and a union where its first part is. In periodic
/// space a ray goes on at the other side, and its hits are on the straight line.
///
/// Cost: a tree over the bodies of the rank, of which each question visits a few; one gathering of
/// their bounds, and two messages between each two ranks, whatever the number of rays. Throws
/// invalid_argument on all ranks for a value that is no number, a direction of length zero, a
/// negative length, and a ray without an end in periodic space; and runtime_error if the ranks call
/// different queries, or in an exclusive section.
template <class Scenario>
[[nodiscard]] std::vector<query_hit> cast_rays(world<Scenario>& w, std::span<const ray> rays,
                                               const query_filter& filter = {}) {
  return detail::first_of_each(
      detail::ask_rays<detail::query_kind::first>(w, "cast_rays", rays, filter));
}
/// Collective: all bodies on each ray, each where the ray enters it first, by their distances. An
/// image in periodic space counts as a body. Otherwise as cast_rays().
template <class Scenario>
[[nodiscard]] std::vector<std::vector<query_hit>> cast_rays_through(
    world<Scenario>& w, std::span<const ray> rays, const query_filter& filter = {}) {
  return detail::ask_rays<detail::query_kind::all>(w, "cast_rays_through", rays, filter);
}
/// Collective: the first body that a shape meets on each way, as cast_rays(); `distance` is that of
/// the way. It is too short by at most 1e-9 of the two bounding radii over the cosine of the angle
/// of incidence, and a shape that passes as closely may count as a hit. `normal` is exact to about
/// 1e-6 at smooth surfaces. At most 64 advances for each pair of convex parts. Also throws
/// invalid_argument for an invalid shape or orientation.
template <class Scenario, class Shape>
[[nodiscard]] std::vector<query_hit> cast_shape(world<Scenario>& w, const Shape& shape,
                                                std::span<const shape_path> paths,
                                                const query_filter& filter = {}) {
  return detail::first_of_each(
      detail::ask_paths<detail::query_kind::first>(w, "cast_shape", shape, paths, filter));
}
/// Collective: all bodies that a shape meets on each way, by their distances. See cast_shape().
template <class Scenario, class Shape>
[[nodiscard]] std::vector<std::vector<query_hit>> cast_shape_through(
    world<Scenario>& w, const Shape& shape, std::span<const shape_path> paths,
    const query_filter& filter = {}) {
  return detail::ask_paths<detail::query_kind::all>(w, "cast_shape_through", shape, paths, filter);
}
/// Collective: the bodies that a shape would overlap at each pose, by their ids: `distance` is
/// minus the depth of the deepest contact, `point` and `normal` are those of that contact. Each
/// rank asks with its own poses. Touching without an overlap does not count. Costs and throws as
/// cast_shape().
template <class Scenario, class Shape>
[[nodiscard]] std::vector<std::vector<query_hit>> find_overlaps(world<Scenario>& w,
                                                                const Shape& shape,
                                                                std::span<const pose> poses,
                                                                const query_filter& filter = {}) {
  constexpr const char* what = "find_overlaps";
  std::vector<std::vector<query_hit>> found;
  if constexpr (detail::require_query_shape<Shape>()) {
    std::string fault = detail::fault_of(w, what, filter);
    if (fault.empty()) fault = detail::fault_of(shape);
    std::vector<detail::question> all;
    for (const pose& p : poses) {
      const std::size_t n = all.size();
      if (fault.empty()) fault = detail::fault_of(w, what, n, p.position, vec3(0, 0, 1), 0);
      if (fault.empty()) fault = detail::fault_of(w.rank(), what, n, p.orientation);
      all.push_back(
          {.from = p.position, .turn = p.orientation, .number = static_cast<std::uint32_t>(n)});
    }
    found = detail::ask<detail::query_kind::overlaps>(
        w, what, filter, detail::overlap_probe<Shape>{shape}, all, fault);
  }
  for (auto& hits : found)
    std::sort(hits.begin(), hits.end(),
              [](const query_hit& x, const query_hit& y) { return x.id < y.id; });
  return found;
}
/// Collective: the body whose surface is nearest to each point, if its distance is at most
/// `within`; of bodies that contain the point, that of the least id, at distance 0. Each rank asks
/// with its own points. `point` is on the body (in periodic space on its image nearest to the
/// point), `normal` points from there to the point. Exact to 1e-9 of the distance. Costs and throws
/// as cast_rays().
template <class Scenario>
[[nodiscard]] std::vector<query_hit> nearest_bodies(world<Scenario>& w,
                                                    std::span<const vec3> points,
                                                    real within = detail::endless,
                                                    const query_filter& filter = {}) {
  std::string fault = detail::fault_of(w, "nearest_bodies", filter);
  std::vector<detail::question> all;
  for (const vec3& p : points) {
    const std::size_t n = all.size();
    if (fault.empty()) fault = detail::fault_of(w, "nearest_bodies", n, p, vec3(0, 0, 1), 0);
    if (fault.empty() && !(within >= 0))
      fault = detail::compose(
          "nearest_bodies looks within {} on rank {}: give a distance of 0 or "
          "more",
          within, w.rank());
    all.push_back({p, {1, 0, 0, 0}, vec3(0, 0, 0), within, no_id, static_cast<std::uint32_t>(n)});
  }
  return detail::first_of_each(detail::ask<detail::query_kind::nearest>(
      w, "nearest_bodies", filter, detail::point_probe{}, all, fault));
}
/// Collective: the bodies whose centres are in a region, by their ids, on all ranks: `point` is the
/// centre. All ranks name the same region. Planes have no centre, and are left out. Costs a pass
/// over the bodies and one gathering of what was found. Throws invalid_argument for a region in
/// which no point lies.
template <class Scenario, concepts::region Region>
[[nodiscard]] std::vector<query_hit> bodies_within(world<Scenario>& w, const Region& region,
                                                   const query_filter& filter = {}) {
  w.require_all_ranks("bodies_within");
  detail::require_region(region, "bodies_within");
  detail::asked_bodies<Scenario> bodies(detail::view_of(w));
  std::vector<query_hit> found, all;
  for (const bool global : {false, true})
    if (!global || w.rank() == 0)
      bodies.each(global, filter, [&](const vec3& centre, query_hit hit) {
        if (!region.contains(centre)) return;
        hit.distance = 0, hit.point = centre, hit.inside = true;
        found.push_back(hit);
      });
  detail::byte_buffer mine;
  detail::byte_writer(mine).put(std::span<const query_hit>(found));
  for (const auto& theirs : detail::agree_on_query(
           w, "bodies_within", detail::fault_of(w, "bodies_within", filter), mine)) {
    detail::byte_reader in(theirs);
    for (const query_hit& hit : in.template get_all<query_hit>()) all.push_back(hit);
  }
  std::sort(all.begin(), all.end(),
            [](const query_hit& x, const query_hit& y) { return x.id < y.id; });
  return all;
}

}  // namespace talus
