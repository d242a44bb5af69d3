#pragma once
// Decompositions side by side, each in its part of space.
#include <array>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "talus/parallel/detail/directions.hpp"
#include "talus/parallel/detail/region_map.hpp"

namespace talus {

/// A decomposition of a region instead of all space, as a part of join(...).
template <concepts::decomposition Decomposition>
struct within {
  any_geometry region;
  Decomposition parts;

  within() = default;
  within(any_geometry region, Decomposition parts)
      : region(std::move(region)), parts(std::move(parts)) {}
};

/// The partitions of the parts of a join. A point belongs to the last part whose region contains it
/// (boundaries to the side towards +x, then +y, +z), else to the first part. The partition of the
/// part decides within it.
template <class... Partitions>
class joined_cells {
  static constexpr std::size_t parts_ = sizeof...(Partitions);

 public:
  /// `regions` of all parts, that of the first one being all of space.
  joined_cells(std::array<any_geometry, parts_> regions, std::span<const any_geometry> closed,
               Partitions... partitions)
      : regions_(std::move(regions)), partitions_(std::move(partitions)...) {
    std::vector<detail::territory> given(regions_.begin(), regions_.end()), own;
    each([&](std::size_t part, const auto& cells) {
      first_[part] = static_cast<int>(own.size());
      for (int k = 0; k < cells.size(); ++k) {
        any_geometry region = cells.geometry(k);
        if (region == any_geometry()) {
          region = regions_[part];
        } else if (part > 0) {
          detail::territory common(any_geometry(intersect(regions_[part], region)));
          common.simplify();
          region = common.region;
        }
        own.emplace_back(region, std::span(given).subspan(part + 1));
      }
    });
    first_[parts_] = static_cast<int>(own.size());
    map_ = detail::region_map(std::move(own), closed);
    if (const int empty = map_.first_empty(); empty >= 0)
      detail::fail<std::invalid_argument>(
          "rank {} of the join, cell {} of its part {}, owns no space: the region of that part is "
          "{}, and later parts take theirs from it; correct the regions in within(...), or the "
          "cuts",
          empty, empty - first_[part_of(empty)], part_of(empty),
          to_string(regions_[part_of(empty)]));
  }

  [[nodiscard]] int size() const { return first_[parts_]; }
  [[nodiscard]] int owner(const vec3& point) const {
    if (detail::has_nan(point)) return -1;
    const vec3 p = detail::bounded(point);
    std::size_t part = parts_ - 1;
    while (part > 0 && !regions_[part].owns(p)) --part;
    int result = -1;
    each([&](std::size_t k, const auto& cells) {
      if (k == part) result = first_[k] + cells.owner(p);
    });
    return result;
  }
  [[nodiscard]] std::vector<int> neighbours(int rank, real reach) const {
    const std::size_t part = part_of(rank);
    const std::vector<int> beside =
        of_part(rank, [&](const auto& cells, int k) { return cells.neighbours(k, reach); });
    return select(rank, [&](int other) {
      if (part_of(other) == part && !std::binary_search(beside.begin(), beside.end(), other))
        return false;
      return map_.meet(rank, other, reach) && !map_.meet_on_closed_faces(rank, other);
    });
  }
  /// The ranks that the region of a rank touches on closed faces only, of the join or of a part.
  [[nodiscard]] std::vector<int> closed(int rank) const {
    const std::size_t part = part_of(rank);
    const std::vector<int> own = of_part(rank, [&](const auto& cells, int k) {
      if constexpr (requires { cells.closed(k); }) return cells.closed(k);
      return std::vector<int>{};
    });
    return select(rank, [&](int other) {
      if (part_of(other) == part && std::binary_search(own.begin(), own.end(), other))
        return map_.meet(rank, other, 0);
      return map_.meet_on_closed_faces(rank, other);
    });
  }
  [[nodiscard]] any_geometry geometry(int rank) const { return map_.geometry(rank); }
  [[nodiscard]] std::pair<vec3, vec3> bounds(int rank) const { return map_.bounds(rank); }

 private:
  template <class F>
  void each(F&& f) const {
    std::size_t part = 0;
    std::apply([&](const auto&... cells) { (f(part++, cells), ...); }, partitions_);
  }
  /// One part's answer about one of its cells, in ranks of the join.
  template <class F>
  [[nodiscard]] std::vector<int> of_part(int rank, F&& f) const {
    std::vector<int> ranks;
    each([&](std::size_t part, const auto& cells) {
      if (part == part_of(rank)) ranks = f(cells, rank - first_[part]);
    });
    for (int& r : ranks) r += first_[part_of(rank)];
    return ranks;
  }
  template <class Test>
  [[nodiscard]] std::vector<int> select(int rank, Test&& test) const {
    std::vector<int> ranks;
    for (int other = 0; other < size(); ++other)
      if (other != rank && test(other)) ranks.push_back(other);
    return ranks;
  }
  [[nodiscard]] std::size_t part_of(int rank) const {
    std::size_t part = 0;
    while (part + 1 < parts_ && rank >= first_[part + 1]) ++part;
    return part;
  }

  std::array<any_geometry, parts_> regions_;
  std::array<int, parts_ + 1> first_{};  // rank of each part
  std::tuple<Partitions...> partitions_;
  detail::region_map map_;
};

/// Decompositions side by side. The first one has all of space except for the regions of the
/// others. Each of the others is given as within(region, decomposition); of several regions that
/// contain a point the last one counts. Ranks are numbered part by part. One part may leave its
/// size open.
///   join(grid<9, 1, 7>{.lower = {...}, .upper = {...}},
///        within(half_space(0, 0, -1, 0), slabs<1>{}))             63 ranks, and one below z = 0
template <concepts::generating_decomposition First, concepts::generating_decomposition... Rest>
class join {
  static_assert(sizeof...(Rest) > 0,
                "join<...> takes two decompositions or more, side by side: join(ring<6>{...}, "
                "within(region, slabs<2>{...}))");
  static constexpr std::size_t parts_ = sizeof...(Rest) + 1;

 public:
  /// The parts with their default values, and no regions yet.
  join() : given_(false) {}
  explicit join(First first, within<Rest>... rest)
      : regions_{any_geometry(), std::move(rest.region)...},
        decompositions_(std::move(first), std::move(rest.parts)...) {}

  /// This join with closed faces: ranks that touch only inside one of the given convex regions are
  /// not connected, because no body ever crosses there.
  template <concepts::polyhedral... Faces>
  [[nodiscard]] join closed(const Faces&... faces) const {
    join result = *this;
    result.closed_ = {any_geometry(faces)...};
    return result;
  }

  /// The number of ranks, 0 while it is open.
  [[nodiscard]] int size() const {
    int sum = 0;
    for (const int n : sizes()) {
      if (n == 0) return 0;
      sum += n;
    }
    return sum;
  }

  [[nodiscard]] auto resolve(int ranks) const {
    return resolve_parts(shared_out(ranks), std::make_index_sequence<parts_>());
  }

 private:
  [[nodiscard]] std::array<int, parts_> sizes() const {
    return std::apply([](const auto&... part) { return std::array<int, parts_>{part.size()...}; },
                      decompositions_);
  }
  /// The number of ranks of each part.
  [[nodiscard]] std::array<int, parts_> shared_out(int ranks) const {
    auto n = sizes();
    int known = 0, open = 0;
    std::string list;
    for (const int k : n) {
      known += k;
      open += k == 0;
      list += (list.empty() ? "" : " + ") + (k == 0 ? std::string("?") : std::to_string(k));
    }
    if (open > 1)
      detail::fail<std::invalid_argument>(
          "{} parts of the join ({} ranks) leave their number of ranks open: say it for all but "
          "one",
          open, list);
    if (open == 1 && ranks == 1) ranks = known + 1;  // one rank takes all; the rest is checked
    if (open == 0 ? known != ranks : known >= ranks)
      detail::fail<std::invalid_argument>(
          "a join of {} ranks needs {} {}, but there are {}: start the program with that many, or "
          "give one of the parts a dynamic size",
          list, open == 0 ? "exactly" : "more than", known, ranks);
    for (int& k : n)
      if (k == 0) k = ranks - known;
    return n;
  }
  template <std::size_t... Part>
  [[nodiscard]] auto resolve_parts(const std::array<int, parts_>& n,
                                   std::index_sequence<Part...>) const {
    if (!given_)
      detail::fail<std::invalid_argument>(
          "the join does not know yet which part of space is whose: give "
          "join(first, within(region, second), ...)");
    return joined_cells<decltype(std::get<Part>(decompositions_).resolve(1))...>(
        regions_, closed_, std::get<Part>(decompositions_).resolve(n[Part])...);
  }

  bool given_ = true;
  std::array<any_geometry, parts_> regions_;
  std::tuple<First, Rest...> decompositions_;
  std::vector<any_geometry> closed_;
};

}  // namespace talus
