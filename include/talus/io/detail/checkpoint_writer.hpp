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

[[nodiscard, gnu::cold]] std::uint64_t checksum_of_rest(int file, const checkpoint_block& block);

class checkpoint_kind final : public file_kind {
 public:
  [[nodiscard]] const char* name() const override { return "the checkpoint"; }
  [[nodiscard]] const output_kind& looks() const override { return checkpoint_output; }
  [[nodiscard]] bool durable() const override { return true; }
  [[nodiscard, gnu::cold]] std::uint32_t block_bytes(std::size_t columns) override;
  void placed(std::uint64_t at, std::uint64_t bytes) override {
    block_.ranges.push_back({at, bytes});
  }
  [[gnu::cold]] void describe(hid_t file, const table_part& t, std::size_t k,
                              const counted_rows& counts) override;
  [[gnu::cold]] void seal(int file, const sparse_bytes& but_rows, std::uint64_t bytes) override;
  [[gnu::cold]] void verify(int file) override;

 private:
  checkpoint_block block_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_writer_definitions.hpp"
#endif
