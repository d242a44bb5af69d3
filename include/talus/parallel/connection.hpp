#pragma once
// A channel to one remote rank, and the region of that rank.
#include "talus/core/bytes.hpp"
#include "talus/geometry/any_geometry.hpp"

namespace talus {

/// The connection of a rank to a remote rank.
struct connection {
  int rank = 0;           ///< The remote rank.
  any_geometry geometry;  ///< Its region, as given on the local rank.
  real overlap = 0;  ///< Widening of that region (a length) for the placement of shadow copies.

  /// A lower bound of the distance from a point to the widened region; negative well inside it.
  [[nodiscard]] real distance(const vec3& p) const { return -geometry.value(p) - overlap; }

  friend bool operator==(const connection&, const connection&) = default;

  void write(detail::byte_writer& out) const {
    out.put(rank);
    geometry.write(out);
    out.put(overlap);
  }
  [[nodiscard]] static connection read(detail::byte_reader& in) {
    connection c;
    c.rank = in.get<int>();
    c.geometry = any_geometry::read(in);
    c.overlap = in.get<real>();
    return c;
  }
};

namespace detail {

/// The connected rank that claims a point, for connections by hand: of several the one with the
/// smallest value (the innermost region), then the most specific one, then the lowest; -1 if none
/// does.
[[nodiscard]] inline int claimant(std::span<const connection> connections, const vec3& p) {
  const connection* best = nullptr;
  real value = 0;
  for (const connection& c : connections) {
    if (!c.geometry.owns(p)) continue;
    const real v = c.geometry.value(p);
    if (best && (v > value || (v == value && c.geometry.depth() <= best->geometry.depth())))
      continue;
    best = &c;
    value = v;
  }
  return best ? best->rank : -1;
}

}  // namespace detail

}  // namespace talus
