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
[[nodiscard]] inline std::array<double, 6> empty_box() {
  constexpr double most = std::numeric_limits<double>::max();
  return {most, most, most, -most, -most, -most};
}
inline void enlarge(std::array<double, 6>& box, const vec3& p) {
  for (int k = 0; k < 3; ++k) {
    auto& lower = box[static_cast<std::size_t>(k)];
    auto& upper = box[static_cast<std::size_t>(k + 3)];
    lower = std::min(lower, p[k]);
    upper = std::max(upper, p[k]);
  }
}
[[nodiscard]] inline bool overlap(const std::array<double, 6>& box, const vec3& lower,
                                  const vec3& upper) {
  bool all = true;
  for (int k = 0; k < 3; ++k)
    all = all && box[static_cast<std::size_t>(k)] <= upper[k] &&
          box[static_cast<std::size_t>(k + 3)] >= lower[k];
  return all;
}

/// Of a piece: its rows in each column, and their extras. `column(k)` returns the bytes.
template <class Column>
[[nodiscard]] std::uint64_t checksum_of_piece(std::size_t columns, Column&& column,
                                              std::span<const std::byte> extra) {
  std::uint64_t sum = checksum_of(extra, columns);
  for (std::size_t k = 0; k < columns; ++k) sum = mix(sum) + checksum_of(column(k), k);
  return sum;
}

/// Divides the rows into pieces; their boxes and extras are filled in later.
[[gnu::cold]] inline void cut_into_pieces(table_part& t) {
  t.pieces.clear();
  for (std::uint64_t first = 0; first < t.rows; first += rows_in_piece) {
    table_piece p;
    p.first = first;
    p.rows = std::min(rows_in_piece, t.rows - first);
    p.box = empty_box();
    t.pieces.push_back(p);
  }
}

/// When all rows are complete.
[[gnu::cold]] inline void sum_up_pieces(table_part& t) {
  for (table_piece& p : t.pieces)
    p.checksum = checksum_of_piece(
        t.columns.size(),
        [&](std::size_t k) {
          const table_column& c = t.columns[k];
          return std::span(c.rows + p.first * c.row_bytes(), p.rows * c.row_bytes());
        },
        std::span<const std::byte>(t.extra).subspan(p.extra_first, p.extra_bytes));
}

/// A table that is read, piece by piece.
class table_reader {
 public:
  /// `columns` are the expected ones.
  table_reader(hid_t file, const std::string& path, std::vector<table_column> columns, bool extras)
      : path_(path), columns_(std::move(columns)) {
    bool first = true;
    for (table_column& c : columns_) {
      sets_.emplace_back(file, path + "/" + c.name, c.type, c.width);
      if (!first && sets_.back().rows() != rows_) refuse();
      rows_ = sets_.back().rows();
      first = false;
    }
    if (extras) extras_.emplace_back(file, path + "/extra", number_type::u8, 1);
    const open_dataset numbers(file, path + "/pieces", number_type::u64, 5);
    const open_dataset boxes(file, path + "/boxes", number_type::f64, 6);
    if (numbers.rows() != boxes.rows() || numbers.rows() > rows_) refuse();
    std::vector<std::array<std::uint64_t, 5>> n(numbers.rows());
    std::vector<std::array<double, 6>> b(numbers.rows());
    numbers.read(0, n.size(), n.data());
    boxes.read(0, b.size(), b.data());
    const std::uint64_t bytes = extras ? extras_[0].rows() : 0;
    std::uint64_t next = 0, next_extra = 0;
    for (std::size_t k = 0; k < n.size(); ++k) {
      const table_piece p{n[k][0], n[k][1], n[k][2], n[k][3], n[k][4], b[k]};
      if (p.first != next || p.rows > rows_in_piece || p.rows > rows_ - next ||
          p.extra_first != next_extra || p.extra_bytes > bytes - next_extra)
        refuse();
      next += p.rows;
      next_extra += p.extra_bytes;
      pieces_.push_back(p);
    }
    if (next != rows_ || next_extra != bytes) refuse();
  }
  [[nodiscard]] std::uint64_t rows() const { return rows_; }
  [[nodiscard]] std::span<const table_piece> pieces() const { return pieces_; }

  /// Reads a piece and checks it; then row() and extra() refer to it.
  void read(const table_piece& p) {
    rows_read_.resize(columns_.size());
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      rows_read_[k].resize(p.rows * columns_[k].row_bytes());
      sets_[k].read(p.first, p.rows, rows_read_[k].data());
    }
    extra_.resize(p.extra_bytes);
    if (!extras_.empty()) extras_[0].read(p.extra_first, p.extra_bytes, extra_.data());
    const auto sum = checksum_of_piece(
        columns_.size(), [&](std::size_t k) { return std::span<const std::byte>(rows_read_[k]); },
        extra_);
    if (sum != p.checksum)
      fail<std::runtime_error>("is damaged: the checksum of rows {} to {} of its table {} is wrong",
                               p.first, p.first + p.rows - 1, path_);
  }
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
  [[noreturn]] void refuse() const {
    fail<std::runtime_error>("is damaged: the parts of its table {} do not fit together", path_);
  }
  std::string path_;
  std::vector<table_column> columns_;
  std::vector<open_dataset> sets_, extras_;
  std::uint64_t rows_ = 0;
  std::vector<table_piece> pieces_;
  std::vector<byte_buffer> rows_read_;
  byte_buffer extra_;
};

}  // namespace talus::detail
