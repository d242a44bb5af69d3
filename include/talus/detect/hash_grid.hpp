#pragma once
// Broad phase: all pairs of balls that touch, from a hierarchy of cell grids rebuilt for each
// search. A body lies in one cell of the level for its size. The search for its partners covers its
// own level and coarser ones only, so the cost per body depends neither on the number of bodies nor
// on the ratio of their sizes.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/detect/detail/grid_level.hpp"
#include "talus/detect/detail/lanes.hpp"
#include "talus/detect/detail/pair_batch.hpp"
#include "talus/detect/detail/size_classes.hpp"
#include "talus/detect/placeable.hpp"

namespace talus {

/// Buffers are reused, so that a rebuild allocates only to grow. The order of pairs depends on the
/// input alone.
class hash_grid {
 public:
  /// Sorts the balls into cells and replaces the previous ones. `reaches` are radii (length) with
  /// the contact margin. Throws unplaceable, which carries the index of the body.
  void build(std::span<const vec3> centres, std::span<const real> reaches);

  [[nodiscard]] std::size_t size() const { return index_.size(); }
  /// Memory held, in bytes.
  [[nodiscard]] std::size_t bytes() const;
  /// Number of cell sizes in use.
  [[nodiscard]] std::size_t levels() const { return levels_.size(); }

  /// Calls f(i, j) once for every unordered pair i != j with |ci - cj| <= ri + rj.
  template <class F>
  void pairs(F&& f) const {
    auto take = [&](std::uint32_t i, std::uint32_t j) { f(i, j); };
    detail::pair_batch found(take);
    find_pairs(found);
    found.flush();
  }

  /// Calls f(i of this, j of other) for every such pair with |ci - cj| <= ri + rj.
  template <class F>
  void pairs_with(const hash_grid& other, F&& f) const {
    auto take = [&](std::uint32_t i, std::uint32_t j) { f(i, j); };
    detail::pair_batch found(take);
    find_pairs_with(other, found);
    found.flush();
  }

  /// Calls f(i) for every ball i with |ci - centre| <= ri + reach, for any finite reach.
  template <class F>
  void query(const vec3& centre, real reach, F&& f) const {
    auto take = [&](std::uint32_t i, std::uint32_t) { f(i); };
    detail::pair_batch found(take);
    const detail::ball ball{centre[0], centre[1], centre[2], reach};
    for (const level& l : levels_) probe(l, ball, {found, 0, false});
    found.flush();
  }

 private:
  using level = detail::grid_level;

  [[nodiscard]] detail::ball ball(std::uint32_t i) const;

  /// The destination of the partners of one body, and whether the body is the first of the pair.
  struct partners {
    detail::pair_batch& found;
    std::uint32_t body;
    bool first;
  };
  // Collects the entries from `first` to `last` that touch a ball.
  void scan(const detail::ball& a, std::uint32_t first, std::uint32_t last,
            const partners& of) const;
  // Bit q: entry k + q touches the ball, and comes before `last`.
  [[nodiscard]] std::uint32_t touching(const detail::ball& a, std::uint32_t k,
                                       std::uint32_t last) const;

  // Calls f(first, last) for the entries of `count` buckets in a row, which may wrap around.
  template <class F>
  void buckets(const level& l, std::uint32_t from, std::uint32_t count, F&& f) const {
    const std::uint32_t* start = starts_.data() + l.bucket;
    if (from + count <= l.buckets) {
      f(start[from], start[from + count]);
    } else {
      f(start[from], start[l.buckets]);
      f(start[0], start[from + count - l.buckets]);
    }
  }

  void find_pairs(detail::pair_batch& found) const;
  void find_pairs_with(const hash_grid& other, detail::pair_batch& found) const;
  void pairs_within(const level& l, detail::pair_batch& found) const;
  void pairs_of_crowd(const level& l, std::uint32_t bucket, detail::pair_batch& found) const;
  void probe(const level& l, const detail::ball& ball, const partners& of) const;

  std::vector<level> levels_;  // coarsest first
  // Entries, sorted by level and bucket; a few more coordinates may be read but are not used.
  detail::plain_vector<real> x_, y_, z_, reach_;
  detail::plain_vector<std::uint32_t> index_;  // of the body of each entry
  detail::plain_vector<std::uint32_t>
      starts_;  // first entry of each bucket, levels one after the other
  detail::plain_vector<std::uint32_t> bucket_;  // of each body
  detail::size_classes classes_;
};

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/detect/hash_grid_definitions.hpp"
#endif
