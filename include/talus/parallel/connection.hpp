#pragma once
// A channel to one remote rank, and the region of that rank.
#include "talus/core/bytes.hpp"
#include "talus/geometry/any_geometry.hpp"

namespace talus {

/// The connection of a rank to a remote rank.
struct connection {
  int rank = 0;           ///< The remote rank.
  any_geometry geometry;  ///< The region of that rank, as given on the local rank.
  real overlap = 0;  ///< Widening of that region (a length) for the placement of shadow copies.

  /// A lower bound of the distance from a point to the widened region; negative well inside it.
  [[nodiscard]] real distance(const vec3& p) const { return -geometry.value(p) - overlap; }

  friend bool operator==(const connection&, const connection&) = default;

  void write(detail::byte_writer& out) const;
  [[nodiscard]] static connection read(detail::byte_reader& in);
};

namespace detail {

/// The connected rank that claims a point, for connections by hand: of several the one with the
/// smallest value (the innermost region), then the most specific one, then the lowest; -1 if none
/// does.
[[nodiscard]] int claimant(std::span<const connection> connections, const vec3& p);

}  // namespace detail

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/parallel/connection_definitions.hpp"
#endif
