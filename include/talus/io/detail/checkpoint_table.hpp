#pragma once
// Tables of a checkpoint: columns of equal length, one dataset each, in pieces that are read and
// checked one by one.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/io/detail/checkpoint_block.hpp"
#include "talus/io/detail/hdf5.hpp"

namespace talus::detail {

inline constexpr std::uint64_t rows_in_piece = 1 << 14;

/// Consecutive rows of one rank. In the file six numbers and a box.
struct table_piece {
  std::uint64_t first = 0, rows = 0;
  std::uint64_t extra_first = 0, extra_bytes = 0;  ///< of data without a fixed length
  std::uint64_t checksum = 0;
  std::array<double, 6> box{};  ///< lower and upper corner of the bodies' centres
};

struct table_column {
  std::string name;
  number_type type = number_type::f64;
  std::uint32_t width = 1;
  const std::byte* rows = nullptr;  ///< of this rank
  [[nodiscard]] std::size_t row_bytes() const { return bytes_of(type) * width; }
};

/// The part of a table that one rank writes.
struct table_part {
  std::string path;
  std::uint64_t rows = 0;
  std::vector<table_column> columns;
  bool extras = false;  ///< a dataset of bytes, to which rows refer
  byte_buffer extra;
  std::vector<table_piece> pieces;  ///< `first` counts from the rank's first row, likewise extras
  /// The storage to which the columns point, if that is not the world itself.
  std::vector<byte_buffer> memory;
};

/// An empty box.
[[nodiscard]] std::array<double, 6> empty_box();
void enlarge(std::array<double, 6>& box, const vec3& p);
[[nodiscard]] bool overlap(const std::array<double, 6>& box, const vec3& lower, const vec3& upper);

/// The checksum of a piece: of its rows in each column, and of their extras. `column(k)` returns
/// the bytes of a column.
template <class Column>
[[nodiscard]] std::uint64_t checksum_of_piece(std::size_t columns, Column&& column,
                                              std::span<const std::byte> extra) {
  std::uint64_t sum = checksum_of(extra, columns);
  for (std::size_t k = 0; k < columns; ++k) sum = mix(sum) + checksum_of(column(k), k);
  return sum;
}

/// Divides the rows into pieces; their boxes and extras are filled in later.
[[gnu::cold]] void cut_into_pieces(table_part& t);

/// When all rows are complete.
[[gnu::cold]] void sum_up_pieces(table_part& t);

/// A table that is read, piece by piece.
class table_reader {
 public:
  /// `columns` are the expected ones.
  table_reader(hid_t file, const std::string& path, std::vector<table_column> columns, bool extras);
  [[nodiscard]] std::uint64_t rows() const { return rows_; }
  [[nodiscard]] std::span<const table_piece> pieces() const { return pieces_; }

  /// Reads a piece and checks it; then row() and extra() refer to it.
  void read(const table_piece& p);
  /// The bytes of row `i` of the piece, in a column.
  [[nodiscard]] const std::byte* row(std::size_t column, std::uint64_t i) const {
    return rows_read_[column].data() + i * columns_[column].row_bytes();
  }
  template <class T>
  [[nodiscard]] T get(std::size_t column, std::uint64_t i) const {
    T value;
    std::memcpy(static_cast<void*>(&value), row(column, i), sizeof(T));
    return value;
  }
  [[nodiscard]] std::span<const std::byte> extra() const { return extra_; }

 private:
  [[noreturn]] void refuse() const;
  std::string path_;
  std::vector<table_column> columns_;
  std::vector<open_dataset> sets_, extras_;
  std::uint64_t rows_ = 0;
  std::vector<table_piece> pieces_;
  std::vector<byte_buffer> rows_read_;
  byte_buffer extra_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_table_definitions.hpp"
#endif
