#pragma once
// The definitions of checkpoint_places.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_places.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE counted_rows gather_counts(checkpoint_team& team,
                                             const std::vector<table_part>& tables) {
  byte_buffer mine;
  byte_writer out(mine);
  for (const table_part& t : tables) {
    out.put(t.rows);
    out.put(static_cast<std::uint64_t>(t.extra.size()));
    out.put(std::span<const table_piece>(t.pieces));
  }
  counted_rows all;
  for (const byte_buffer& bytes : team.gather(mine)) {
    byte_reader in(bytes);
    auto& one = all.emplace_back();
    for (std::size_t k = 0; k < tables.size(); ++k) {
      counted_part c;
      c.rows = in.get<std::uint64_t>();
      c.extra = in.get<std::uint64_t>();
      const auto pieces = in.get_all<table_piece>();
      c.pieces.assign(pieces.begin(), pieces.end());
      one.push_back(std::move(c));
    }
  }
  return all;
}

TALUS_HDF5_INLINE std::vector<table_place> share_places(checkpoint_team& team, std::size_t tables,
                                                        const counted_rows& counts) {
  byte_buffer bytes;
  if (team.rank() == 0) {
    byte_writer out(bytes);
    std::vector<table_place> next(tables);
    for (const auto& one : counts)
      for (std::size_t k = 0; k < tables; ++k) {
        out.put(next[k]);
        next[k].row += one[k].rows;
        next[k].extra += one[k].extra;
      }
  }
  team.broadcast(bytes);
  byte_reader in(bytes);
  std::vector<table_place> mine(tables);
  for (int r = 0; r <= team.rank(); ++r)
    for (table_place& p : mine) p = in.get<table_place>();
  return mine;
}

}  // namespace talus::detail
