#pragma once
// A table that is filled row by row and sorted, before all ranks write it.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/io/detail/checkpoint_table.hpp"

namespace talus::detail {

/// Each row is a key and one value for each column, in the order of the columns.
class row_table {
 public:
  /// The sort key; rows of equal keys stay in the order of insertion.
  using key = std::array<std::uint64_t, 3>;

  explicit row_table(std::string path) { part_.path = std::move(path); }

  row_table& column(const char* name, number_type type, std::uint32_t width = 1);
  void begin_row(const key& k);
  /// Values in any number whose bytes are those of the next column.
  template <class... Values>
  void put(const Values&... values) {
    byte_writer out(part_.memory[next_++]);
    (out.put(values), ...);
  }
  [[nodiscard]] std::size_t rows() const { return keys_.size(); }

  /// The table, its rows sorted.
  [[nodiscard, gnu::cold]] table_part take();

 private:
  table_part part_;
  std::vector<key> keys_;
  std::size_t next_ = 0;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/row_table_definitions.hpp"
#endif
