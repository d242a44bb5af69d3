#pragma once
// The definitions of checkpoint_writer.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_writer.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::uint64_t checksum_of_rest(int file, const checkpoint_block& block) {
  return checksum_of_rest(
      block, [&](std::uint64_t at, std::span<std::byte> into) { return read_at(file, at, into); });
}

TALUS_HDF5_INLINE std::uint32_t checkpoint_kind::block_bytes(std::size_t columns) {
  block_ = {};
  return block_.block_bytes = block_bytes_for(columns);
}

TALUS_HDF5_INLINE void checkpoint_kind::describe(hid_t file, const table_part& t, std::size_t k,
                                                 const counted_rows& counts) {
  table_place all;
  std::vector<std::uint64_t> numbers;
  std::vector<double> boxes;
  for (const auto& one : counts) {
    for (const table_piece& p : one[k].pieces) {
      numbers.insert(numbers.end(), {p.first + all.row, p.rows, p.extra_first + all.extra,
                                     p.extra_bytes, p.checksum});
      boxes.insert(boxes.end(), p.box.begin(), p.box.end());
    }
    all.row += one[k].rows;
    all.extra += one[k].extra;
  }
  write_small(file, t.path + "/pieces", number_type::u64, numbers.size() / 5, 5, numbers.data());
  write_small(file, t.path + "/boxes", number_type::f64, boxes.size() / 6, 6, boxes.data());
}

TALUS_HDF5_INLINE void checkpoint_kind::seal(int file, const sparse_bytes& but_rows,
                                             std::uint64_t bytes) {
  block_.file_bytes = bytes;
  std::sort(block_.ranges.begin(), block_.ranges.end(),
            [](const byte_range& a, const byte_range& b) { return a.first < b.first; });
  block_.rest_checksum = checksum_of_rest(block_, [&](std::uint64_t at, std::span<std::byte> into) {
    but_rows.read(at, into);
    return true;
  });
  const byte_buffer block = compose_block(block_);
  if (write_at(file, 0, block) != block.size())
    fail<std::runtime_error>("cannot be written to the disk: {}", system_words());
}

TALUS_HDF5_INLINE void checkpoint_kind::verify(int file) {
  byte_buffer head(block_.block_bytes);
  if (!read_at(file, 0, head)) throw std::runtime_error("cannot be read back from the disk");
  if (checksum_of_rest(file, read_block(head, block_.file_bytes)) != block_.rest_checksum)
    throw std::runtime_error("is not on the disk as it was written: is the disk sound?");
}

}  // namespace talus::detail
