#pragma once
// The parts that make an HDF5 file a checkpoint: the first block with checksums, and for each table
// the list of its pieces with the boxes of their bodies.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "talus/io/detail/checkpoint_block.hpp"
#include "talus/io/detail/team_writer.hpp"

namespace talus::detail {

/// Checksum of the bytes outside of the ranges. `read(place, bytes)` fills in bytes of the file,
/// and returns whether it could.
template <class Read>
[[nodiscard, gnu::cold]] std::uint64_t checksum_of_rest(const checkpoint_block& block,
                                                        Read&& read) {
  constexpr std::uint64_t chunk = 1 << 20;
  byte_buffer bytes;
  std::uint64_t sum = 0;
  each_part_of_rest(block, [&](byte_range part) {
    while (part.bytes > 0) {
      bytes.resize(std::min(chunk, part.bytes));
      if (!read(part.first, std::span(bytes)))
        throw std::runtime_error("cannot be read to its end");
      sum = mix(sum) + checksum_of(bytes, part.first);
      part.first += bytes.size();
      part.bytes -= bytes.size();
    }
  });
  return sum;
}

[[nodiscard, gnu::cold]] inline std::uint64_t checksum_of_rest(int file,
                                                               const checkpoint_block& block) {
  return checksum_of_rest(
      block, [&](std::uint64_t at, std::span<std::byte> into) { return read_at(file, at, into); });
}

class checkpoint_kind final : public file_kind {
 public:
  [[nodiscard]] const char* name() const override { return "the checkpoint"; }
  [[nodiscard]] const output_kind& looks() const override { return checkpoint_output; }
  [[nodiscard]] bool durable() const override { return true; }
  [[nodiscard, gnu::cold]] std::uint32_t block_bytes(std::size_t columns) override {
    block_ = {};
    return block_.block_bytes = block_bytes_for(columns);
  }
  void placed(std::uint64_t at, std::uint64_t bytes) override {
    block_.ranges.push_back({at, bytes});
  }
  [[gnu::cold]] void describe(hid_t file, const table_part& t, std::size_t k,
                              const counted_rows& counts) override {
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
  [[gnu::cold]] void seal(int file, const sparse_bytes& but_rows, std::uint64_t bytes) override {
    block_.file_bytes = bytes;
    std::sort(block_.ranges.begin(), block_.ranges.end(),
              [](const byte_range& a, const byte_range& b) { return a.first < b.first; });
    block_.rest_checksum =
        checksum_of_rest(block_, [&](std::uint64_t at, std::span<std::byte> into) {
          but_rows.read(at, into);
          return true;
        });
    const byte_buffer block = compose_block(block_);
    if (write_at(file, 0, block) != block.size())
      fail<std::runtime_error>("cannot be written to the disk: {}", system_words());
  }
  [[gnu::cold]] void verify(int file) override {
    byte_buffer head(block_.block_bytes);
    if (!read_at(file, 0, head)) throw std::runtime_error("cannot be read back from the disk");
    if (checksum_of_rest(file, read_block(head, block_.file_bytes)) != block_.rest_checksum)
      throw std::runtime_error("is not on the disk as it was written: is the disk sound?");
  }

 private:
  checkpoint_block block_;
};

}  // namespace talus::detail
