#pragma once
// The definitions of connection.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/parallel/connection.hpp"

namespace talus {

TALUS_INLINE void connection::write(detail::byte_writer& out) const {
  out.put(rank);
  geometry.write(out);
  out.put(overlap);
}

TALUS_INLINE connection connection::read(detail::byte_reader& in) {
  connection c;
  c.rank = in.get<int>();
  c.geometry = any_geometry::read(in);
  c.overlap = in.get<real>();
  return c;
}

}  // namespace talus

namespace talus::detail {

TALUS_INLINE int claimant(std::span<const connection> connections, const vec3& p) {
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

}  // namespace talus::detail
