#pragma once
// The two concepts behind domains: what a user names, and what it becomes once ranks are known.
#include <concepts>
#include <vector>

#include "talus/geometry/any_geometry.hpp"

namespace talus {

/// An extent that is chosen when the program runs.
inline constexpr int dynamic = -1;

/// How space is shared out, all extents known. `owner` is total (every point of space has exactly
/// one owner, to the last bit, by one transitive rule; only NaN has none: -1), `geometry` is the
/// closed region of a rank, and `neighbours` lists in ascending order, without `rank` itself, every
/// rank whose region comes within `reach` of that of `rank` (more are allowed, at a price).
template <class Partition>
concept partition = std::copyable<Partition> &&
    requires(const Partition& cells, int rank, real reach, const vec3& p) {
  { cells.size() } -> std::same_as<int>;
  { cells.owner(p) } -> std::same_as<int>;
  { cells.neighbours(rank, reach) } -> std::same_as<std::vector<int>>;
  { cells.geometry(rank) } -> std::convertible_to<any_geometry>;
};

/// A way to share out space among ranks, as the user writes it: a plain value. `size()` is the
/// number of ranks it wants, 0 if it fits any. `resolve(ranks)` fixes what is left open and returns
/// the partition; it throws invalid_argument, with both numbers, if they do not go together.
/// by_hand is the one decomposition without a partition: there all connections are the user's.
template <class Decomposition>
concept decomposable = std::copyable<Decomposition> && requires(const Decomposition& d, int ranks) {
  { d.size() } -> std::same_as<int>;
  d.resolve(ranks);
};

/// A decomposition that knows the owner of every point and generates all connections.
template <class Decomposition>
concept generating = decomposable<Decomposition> && requires(const Decomposition& d) {
  { d.resolve(1) } -> partition;
};

}  // namespace talus
