#pragma once
// The definitions of checkpoint_bodies.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_bodies.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::uint64_t rows_within(const table_reader& table,
                                            const std::pair<vec3, vec3>& bounds) {
  std::uint64_t rows = 0;
  for (const table_piece& p : table.pieces())
    if (overlap(p.box, bounds.first, bounds.second)) rows += p.rows;
  return rows;
}

}  // namespace talus::detail
