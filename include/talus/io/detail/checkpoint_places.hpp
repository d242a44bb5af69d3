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
[[nodiscard, gnu::cold]] counted_rows gather_counts(checkpoint_team& team,
                                                    const std::vector<table_part>& tables);

/// Collective. The position of this rank's rows in each table.
[[nodiscard, gnu::cold]] std::vector<table_place> share_places(checkpoint_team& team,
                                                               std::size_t tables,
                                                               const counted_rows& counts);

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_places_definitions.hpp"
#endif
