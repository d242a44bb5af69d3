#pragma once
// The definitions of hash_grid.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/detect/hash_grid.hpp"

namespace talus {

TALUS_INLINE std::size_t hash_grid::bytes() const {
  return 4 * x_.capacity() * sizeof(real) +
         (index_.capacity() + starts_.capacity() + bucket_.capacity()) * sizeof(std::uint32_t);
}

TALUS_INLINE detail::ball hash_grid::ball(std::uint32_t i) const {
  return {x_[i], y_[i], z_[i], reach_[i]};
}

TALUS_INLINE void hash_grid::scan(const detail::ball& a, std::uint32_t first, std::uint32_t last,
                                  const partners& of) const {
  for (std::uint32_t k = first; k < last; k += detail::lanes)
    for (std::uint32_t hits = touching(a, k, last); hits != 0; hits &= hits - 1) {
      const std::uint32_t j = index_[k + static_cast<std::uint32_t>(std::countr_zero(hits))];
      of.first ? of.found.add(of.body, j) : of.found.add(j, of.body);
    }
}

TALUS_INLINE std::uint32_t hash_grid::touching(const detail::ball& a, std::uint32_t k,
                                               std::uint32_t last) const {
  const std::uint32_t valid = (1u << std::min(last - k, detail::lanes)) - 1;
  return detail::touching(a, &x_[k], &y_[k], &z_[k], &reach_[k]) & valid;
}

TALUS_INLINE void hash_grid::find_pairs(detail::pair_batch& found) const {
  for (std::size_t coarse = 0; coarse < levels_.size(); ++coarse) {
    pairs_within(levels_[coarse], found);
    for (std::size_t fine = coarse + 1; fine < levels_.size(); ++fine)
      for (std::uint32_t i = levels_[fine].first; i < levels_[fine].last; ++i)
        probe(levels_[coarse], ball(i), {found, index_[i], true});
  }
}

TALUS_INLINE void hash_grid::find_pairs_with(const hash_grid& other,
                                             detail::pair_batch& found) const {
  for (const level& mine : levels_)
    for (const level& theirs : other.levels_)
      if (mine.cell <= theirs.cell) {
        for (std::uint32_t i = mine.first; i < mine.last; ++i)
          other.probe(theirs, ball(i), {found, index_[i], true});
      } else {
        for (std::uint32_t j = theirs.first; j < theirs.last; ++j)
          probe(mine, other.ball(j), {found, other.index_[j], false});
      }
}

// Every pair of neighbouring cells is visited from the first of the two: the cell itself and the
// rest of its row, then the row behind in y and three rows above in z. All bodies of a bucket share
// these rows. Up to eight candidates are tested at once, and up to 64 before the first result is
// read, because unpredictable branches dominate the cost.
TALUS_INLINE void hash_grid::pairs_within(const level& l, detail::pair_batch& found) const {
  using detail::lanes;
  constexpr std::uint32_t capacity = 64, group = 64 / lanes;
  std::uint32_t first[capacity], last[capacity];
  std::uint32_t slots = 0;
  const auto collect = [&](std::uint32_t from, std::uint32_t to) {
    for (; from < to && slots < capacity; from += lanes) {
      first[slots] = from;
      last[slots++] = to;
    }
  };
  const std::uint32_t rows[4] = {l.row, l.slab - l.row, l.slab, l.slab + l.row};
  const std::uint32_t* start = starts_.data() + l.bucket;
  for (std::uint32_t b = 0; b < l.buckets; ++b) {
    const std::uint32_t begin = start[b], end = start[b + 1];
    if (begin == end) continue;
    slots = 0;
    for (const std::uint32_t r : rows) buckets(l, (b + r - 1) & l.mask, 3, collect);
    std::uint32_t rest = end;  // of the own row
    if (b + 1 < l.buckets)
      rest = start[b + 2];
    else
      collect(start[0], start[1]);
    if (slots + (rest - begin) / lanes + 1 >= capacity) {
      pairs_of_crowd(l, b, found);
      continue;
    }
    const std::uint32_t shared = slots;
    for (std::uint32_t i = begin; i < end; ++i) {
      slots = shared;
      collect(i + 1, rest);
      const detail::ball a = ball(i);
      const std::uint32_t index = index_[i];
      for (std::uint32_t base = 0; base < slots; base += group) {
        std::uint64_t hits = 0;
        const std::uint32_t some = std::min(group, slots - base);
        for (std::uint32_t s = 0; s < some; ++s) {
          const std::uint64_t bits = touching(a, first[base + s], last[base + s]);
          hits |= bits << (lanes * s);
        }
        for (; hits != 0; hits &= hits - 1) {
          const auto bit = static_cast<std::uint32_t>(std::countr_zero(hits));
          found.add(index, index_[first[base + bit / lanes] + bit % lanes]);
        }
      }
    }
  }
}

// Finds the pairs of one bucket with too many candidates to collect.
TALUS_INLINE void hash_grid::pairs_of_crowd(const level& l, std::uint32_t bucket,
                                            detail::pair_batch& found) const {
  const std::uint32_t* start = starts_.data() + l.bucket;
  for (std::uint32_t i = start[bucket]; i < start[bucket + 1]; ++i) {
    const detail::ball a = ball(i);
    const partners of{found, index_[i], true};
    const auto all = [&](std::uint32_t first, std::uint32_t last) { scan(a, first, last, of); };
    scan(a, i + 1, start[bucket + 1], of);
    buckets(l, (bucket + 1) & l.mask, 1, all);
    for (const std::uint32_t r : {l.row, l.slab - l.row, l.slab, l.slab + l.row})
      buckets(l, (bucket + r - 1) & l.mask, 3, all);
  }
}

TALUS_INLINE void hash_grid::probe(const level& l, const detail::ball& ball,
                                   const partners& of) const {
  const real reach = ball.reach + l.largest + l.slack;
  if (!(ball.x - reach <= l.high[0] && ball.x + reach >= l.low[0] && ball.y - reach <= l.high[1] &&
        ball.y + reach >= l.low[1] && ball.z - reach <= l.high[2] && ball.z + reach >= l.low[2]))
    return;
  const std::uint32_t count = l.last - l.first;
  if (count <= 8) return scan(ball, l.first, l.last, of);

  // Clamp as coordinates, since the ball may be of any size.
  const auto lowest = [&](real v, int d) { return l.cell_of(std::max(v - reach, l.low[d])); };
  const auto highest = [&](real v, int d) { return l.cell_of(std::min(v + reach, l.high[d])); };
  const std::int64_t x0 = lowest(ball.x, 0), x1 = highest(ball.x, 0);
  const std::int64_t y0 = lowest(ball.y, 1), y1 = highest(ball.y, 1);
  const std::int64_t z0 = lowest(ball.z, 2), z1 = highest(ball.z, 2);
  const bool small = x1 - x0 < 3 && y1 - y0 < 3 && z1 - z0 < 3;
  if (!small && (!l.exact() || real(y1 - y0 + 1) * real(z1 - z0 + 1) > real(count)))
    return scan(ball, l.first, l.last, of);
  for (std::int64_t z = z0; z <= z1; ++z)
    for (std::int64_t y = y0; y <= y1; ++y)
      buckets(l, l.bucket_of(x0, y, z), static_cast<std::uint32_t>(x1 - x0 + 1),
              [&](std::uint32_t first, std::uint32_t last) { scan(ball, first, last, of); });
}

TALUS_INLINE void hash_grid::build(std::span<const vec3> centres, std::span<const real> reaches) {
  if (centres.size() != reaches.size() || centres.size() >= std::uint32_t(-1) / 8)
    detail::fail<std::invalid_argument>(
        "hash_grid::build was given {} centres and {} reaches; give one reach per centre, below "
        "2^29",
        centres.size(), reaches.size());
  const auto n = static_cast<std::uint32_t>(centres.size());
  levels_.clear();
  for (auto* v : {&x_, &y_, &z_, &reach_}) v->resize(n + detail::lanes);
  index_.resize(n);
  bucket_.resize(n);
  if (n == 0) return;

  constexpr real infinity = std::numeric_limits<real>::infinity();
  real smallest = infinity, largest = 0, poison = 0;
  vec3 low = detail::thrice<real>(infinity), high = -low;
  for (std::uint32_t i = 0; i < n; ++i) {
    const vec3& c = centres[i];
    const real r = reaches[i];
    poison += (c[0] + c[1] + c[2] + r) * 0;  // stays zero if all values are finite
    smallest = std::min(smallest, r);
    largest = std::max(largest, r);
    low = detail::lower_of(low, c);
    high = detail::upper_of(high, c);
  }
  const real furthest = std::max(detail::max_norm(low), detail::max_norm(high));
  if (poison != 0 || !(smallest >= 0) || furthest > real(std::uint64_t{1} << 44) * smallest)
    detail::require_placeable(centres, reaches);

  classes_.plan(reaches, smallest, largest);
  levels_.resize(classes_.levels());
  if (levels_.size() == 1) {
    levels_[0].low = low;
    levels_[0].high = high;
    levels_[0].largest = largest;
    levels_[0].last = n;
  } else {
    for (level& l : levels_) {
      l.low = vec3::Constant(infinity);
      l.high = vec3::Constant(-infinity);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      level& l = levels_[classes_.level_of(reaches[i])];
      ++l.last;
      l.largest = std::max(l.largest, reaches[i]);
      l.low = detail::lower_of(l.low, centres[i]);
      l.high = detail::upper_of(l.high, centres[i]);
    }
  }
  std::uint32_t entry_count = 0, bucket_count = 0;
  for (level& l : levels_) {
    l.lay_out();
    l.first = entry_count;
    l.last = entry_count += l.last;
    l.bucket = bucket_count;
    bucket_count += l.buckets;
  }

  // Counting sort. While scattering, starts_[b + 1] runs from the first to the last of bucket b.
  starts_.assign(bucket_count + 2, 0);
  std::uint32_t* const counts = starts_.data() + 2;
  for (std::uint32_t i = 0; i < n; ++i) {
    const level& l = levels_.size() == 1 ? levels_[0] : levels_[classes_.level_of(reaches[i])];
    const vec3& c = centres[i];
    bucket_[i] = l.bucket + l.bucket_of(l.cell_of(c[0]), l.cell_of(c[1]), l.cell_of(c[2]));
    ++counts[bucket_[i]];
  }
  for (std::uint32_t b = 1; b < bucket_count; ++b) counts[b] += counts[b - 1];
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t at = starts_[bucket_[i] + 1]++;
    x_[at] = centres[i][0];
    y_[at] = centres[i][1];
    z_[at] = centres[i][2];
    reach_[at] = reaches[i];
    index_[at] = i;
  }
}

}  // namespace talus
