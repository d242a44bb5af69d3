#pragma once
// The definitions of checkpoint_table.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_table.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::array<double, 6> empty_box() {
  constexpr double most = std::numeric_limits<double>::max();
  return {most, most, most, -most, -most, -most};
}

TALUS_HDF5_INLINE void enlarge(std::array<double, 6>& box, const vec3& p) {
  for (int k = 0; k < 3; ++k) {
    auto& lower = box[static_cast<std::size_t>(k)];
    auto& upper = box[static_cast<std::size_t>(k + 3)];
    lower = std::min(lower, p[k]);
    upper = std::max(upper, p[k]);
  }
}

TALUS_HDF5_INLINE bool overlap(const std::array<double, 6>& box, const vec3& lower,
                               const vec3& upper) {
  bool all = true;
  for (int k = 0; k < 3; ++k)
    all = all && box[static_cast<std::size_t>(k)] <= upper[k] &&
          box[static_cast<std::size_t>(k + 3)] >= lower[k];
  return all;
}

TALUS_HDF5_INLINE void cut_into_pieces(table_part& t) {
  t.pieces.clear();
  for (std::uint64_t first = 0; first < t.rows; first += rows_in_piece) {
    table_piece p;
    p.first = first;
    p.rows = std::min(rows_in_piece, t.rows - first);
    p.box = empty_box();
    t.pieces.push_back(p);
  }
}

TALUS_HDF5_INLINE void sum_up_pieces(table_part& t) {
  for (table_piece& p : t.pieces)
    p.checksum = checksum_of_piece(
        t.columns.size(),
        [&](std::size_t k) {
          const table_column& c = t.columns[k];
          return std::span(c.rows + p.first * c.row_bytes(), p.rows * c.row_bytes());
        },
        std::span<const std::byte>(t.extra).subspan(p.extra_first, p.extra_bytes));
}

TALUS_HDF5_INLINE table_reader::table_reader(hid_t file, const std::string& path,
                                             std::vector<table_column> columns, bool extras)
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

TALUS_HDF5_INLINE void table_reader::read(const table_piece& p) {
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

TALUS_HDF5_INLINE void table_reader::refuse() const {
  fail<std::runtime_error>("is damaged: the parts of its table {} do not fit together", path_);
}

}  // namespace talus::detail
