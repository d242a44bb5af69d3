#pragma once
// The definitions of checkpoint_bodies.hpp, in the compiled part or in each program.
#include <algorithm>
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

TALUS_HDF5_INLINE std::string path_of_table(const char* group,
                                            std::span<const std::string_view> names,
                                            std::size_t number) {
  const auto before = names.first(number);
  const auto same = std::count(before.begin(), before.end(), names[number]) + 1;
  std::string path = std::string("/") + group + "/" + std::string(names[number]);
  if (same > 1) path += "_" + std::to_string(same);
  return path;
}

}  // namespace talus::detail
