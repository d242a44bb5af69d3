#pragma once
// The user's own regions, one for each rank.
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "talus/parallel/detail/directions.hpp"
#include "talus/parallel/detail/region_map.hpp"

namespace talus {

namespace detail {

/// The position of the first region that contains a point. If none does (in a round-off gap between
/// regions), the position of the nearest one by its value.
class first_region {
 public:
  template <class Region>
  bool operator()(const Region& region, const vec3& p) {
    const real v = region.value(p);
    if (v > value_ || next_ == 0) value_ = v, best_ = next_;
    ++next_;
    return v >= 0;
  }
  [[nodiscard]] int position() const { return best_; }

 private:
  int next_ = 0, best_ = 0;
  real value_ = 0;
};

template <class... Regions>
int first_containing(const std::tuple<Regions...>& regions, const vec3& p) {
  first_region first;
  std::apply([&](const auto&... region) { (void)(first(region, p) || ...); }, regions);
  return first.position();
}
int first_containing(const std::vector<any_geometry>& regions, const vec3& p);

template <class... Regions>
std::vector<any_geometry> as_list(const std::tuple<Regions...>& regions) {
  return std::apply(
      [](const auto&... region) { return std::vector<any_geometry>{any_geometry(region)...}; },
      regions);
}
inline const std::vector<any_geometry>& as_list(const std::vector<any_geometry>& regions) {
  return regions;
}

}  // namespace detail

/// Regions in the order of the ranks. A point belongs to the lowest rank whose region contains it.
template <class List>
class region_cells {
 public:
  /// Throws invalid_argument if the regions leave a gap, or if one of them is empty.
  region_cells(List regions, std::span<const any_geometry> closed) : regions_(std::move(regions)) {
    const std::vector<any_geometry>& all = detail::as_list(regions_);
    std::vector<detail::territory> given, own;
    std::vector<detail::convex_piece> gap(1);
    for (const any_geometry& region : all) {
      own.emplace_back(region, given);
      given.emplace_back(region);
      gap = detail::without(std::move(gap), given.back().pieces);
    }
    if (!gap.empty())
      detail::fail<std::invalid_argument>(
          "the regions of cells leave a gap: no rank owns {} or the space around it ({}); make the "
          "regions cover all of space, for instance the last one by complement(merge(...)) of the "
          "others",
          detail::text(detail::deepest_point(gap.front()).point),
          to_string(any_geometry::cell(gap.front())));
    map_ = detail::region_map(std::move(own), closed);
    if (const int empty = map_.first_empty(); empty >= 0)
      detail::fail<std::invalid_argument>(
          "the region of rank {} in cells has no space of its own: {}, and lower ranks own all of "
          "it; make the regions of lower ranks smaller",
          empty, to_string(all[static_cast<std::size_t>(empty)]));
  }

  [[nodiscard]] int size() const { return map_.size(); }
  [[nodiscard]] int owner(const vec3& p) const {
    return detail::has_nan(p) ? -1 : detail::first_containing(regions_, detail::bounded(p));
  }
  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const {
    return select(rank, [&](int other) {
      return map_.meet(rank, other, reach) && !map_.meet_on_closed_faces(rank, other);
    });
  }
  /// The ranks that the region of a rank touches on closed faces only.
  [[nodiscard]] std::vector<int> closed(int rank) const {
    return select(rank, [&](int other) { return map_.meet_on_closed_faces(rank, other); });
  }
  /// The rest of the user's region without those of the lower ranks.
  [[nodiscard]] any_geometry geometry(int rank) const { return map_.geometry(rank); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const { return map_.bounds(rank); }

 private:
  template <class Test>
  [[nodiscard]] std::vector<int> select(int rank, Test&& test) const {
    std::vector<int> ranks;
    for (int other = 0; other < size(); ++other)
      if (other != rank && test(other)) ranks.push_back(other);
    return ranks;
  }

  List regions_;
  detail::region_map map_;
};

/// A region for each rank, of half-spaces, intersect, merge and complement: any form bounded by
/// planes, also non-convex ones. A point belongs to the lowest rank whose region contains it, so
/// regions may overlap; they must cover space.
///   cells(merge(half_space(-1, 0, 0, -2), half_space(0, -1, 0, -1)),       an L and
///         intersect(half_space(1, 0, 0, 2), half_space(0, 1, 0, 1)))       the quarter space in it
/// cells<> takes a list of regions made at run time: cells(std::vector<any_geometry>{...}).
template <class... Regions>
class cells {
 public:
  using list = std::conditional_t<sizeof...(Regions) == 0, std::vector<any_geometry>,
                                  std::tuple<Regions...>>;
  static_assert((... && concepts::polyhedral<Regions>),
                "cells<...> takes regions bounded by planes: half_space, intersect(...), "
                "merge(...), complement(...) or any_geometry");

  /// No regions yet.
  cells() = default;
  explicit cells(Regions... regions) requires(sizeof...(Regions) > 0)
      : regions_(list(std::move(regions)...)) {}
  explicit cells(std::vector<any_geometry> regions) requires(sizeof...(Regions) == 0)
      : regions_(std::move(regions)) {}

  /// These cells with closed faces: ranks that touch only inside one of the given convex regions
  /// are not connected, because no body ever crosses there.
  template <concepts::polyhedral... Faces>
  [[nodiscard]] cells closed(const Faces&... faces) const {
    cells result = *this;
    result.closed_ = {any_geometry(faces)...};
    return result;
  }

  /// The number of ranks.
  [[nodiscard]] int size() const {
    if constexpr (sizeof...(Regions) > 0)
      return sizeof...(Regions);
    else
      return regions_ ? static_cast<int>(regions_->size()) : 0;
  }

  [[nodiscard]] region_cells<list> resolve(int ranks) const {
    if (!regions_ || size() == 0)
      detail::fail<std::invalid_argument>(
          "cells have no regions yet: give cells(...) one for each "
          "rank");
    if (size() != ranks)
      detail::fail<std::invalid_argument>(
          "cells of {} region(s) need exactly {} ranks, but there are {}: start the program with "
          "that many, or give as many regions",
          size(), size(), ranks);
    return {*regions_, closed_};
  }

 private:
  std::optional<list> regions_;
  std::vector<any_geometry> closed_;
};
template <concepts::polyhedral... Regions>
cells(Regions...) -> cells<Regions...>;
cells(std::vector<any_geometry>)->cells<>;

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/cells_definitions.hpp"
#endif
