#pragma once
// The rows of a table that each rank writes.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/io/detail/checkpoint_team.hpp"

namespace talus::detail {

/// The part of a rank in a table.
struct counted_part {
  std::uint64_t rows = 0, extra = 0;
  std::vector<table_piece> pieces;
};
/// By rank and table.
using counted_rows = std::vector<std::vector<counted_part>>;

/// The position of the rows of a rank in each table: rows and bytes of extras.
struct table_place {
  std::uint64_t row = 0, extra = 0;
};

/// Collective. Of every rank, on rank 0: rows and pieces of every table.
[[nodiscard, gnu::cold]] inline counted_rows gather_counts(checkpoint_team& team,
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

/// Collective. The position of this rank's rows in each table.
[[nodiscard, gnu::cold]] inline std::vector<table_place> share_places(checkpoint_team& team,
                                                                      std::size_t tables,
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
