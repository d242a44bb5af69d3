#pragma once
// What makes an HDF5 file a checkpoint: the first block with checksums, and what says of each table
// which rows belong together and where their bodies are.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "talus/io/detail/checkpoint_block.hpp"
#include "talus/io/detail/team_writer.hpp"

namespace talus::detail {

/// Checksum of what no range covers.
[[nodiscard, gnu::cold]] inline std::uint64_t checksum_of_rest(const system_file& file,
                                                               const checkpoint_block& block) {
  constexpr std::uint64_t chunk = 1 << 20;
  byte_buffer bytes;
  std::uint64_t sum = 0;
  each_part_of_rest(block, [&](byte_range part) {
    while (part.bytes > 0) {
      bytes.resize(std::min(chunk, part.bytes));
      if (!file.read(part.first, bytes)) throw std::runtime_error("cannot be read to its end");
      sum = mix(sum) + checksum_of(bytes, part.first);
      part.first += bytes.size();
      part.bytes -= bytes.size();
    }
  });
  return sum;
}

class checkpoint_kind final : public file_kind {
 public:
  [[nodiscard]] const char* name() const override { return "the checkpoint"; }
  [[nodiscard]] bool durable() const override { return true; }
  [[nodiscard, gnu::cold]] std::uint32_t block_bytes(std::size_t columns) override {
    block_ = {};
    return block_.block_bytes = block_bytes_for(columns);
  }
  [[nodiscard]] std::uint64_t more_bytes(const counted_part& part) const override {
    return part.pieces.size() * 88;
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
  [[gnu::cold]] void seal(const system_file& file, std::uint64_t bytes) override {
    block_.file_bytes = bytes;
    std::sort(block_.ranges.begin(), block_.ranges.end(),
              [](const byte_range& a, const byte_range& b) { return a.first < b.first; });
    block_.rest_checksum = checksum_of_rest(file, block_);
    if (!file.write(0, compose_block(block_)))
      fail<std::runtime_error>("cannot be written to the disk: {}", system_words());
  }

 private:
  checkpoint_block block_;
};

}  // namespace talus::detail
