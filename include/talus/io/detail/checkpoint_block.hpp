#pragma once
// The first bytes of a checkpoint, before the HDF5 file proper (its user block): the type of the
// file, its length, and a checksum of everything except the rows of tables, which have their own.
// It is read before HDF5 reads a byte, and written last.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/io/output_kinds.hpp"

namespace talus::detail {

inline constexpr std::uint32_t checkpoint_version = 1;

/// Sum of a hash of each 8 bytes with their place (splitmix64, Steele, Lea, Flood 2014), the last
/// ones padded with zeros. As the hash is a bijection, every change within 8 bytes is detected, and
/// of others all but one in 2^64. Not a protection against forgery.
[[nodiscard]] std::uint64_t checksum_of(std::span<const std::byte> bytes, std::uint64_t place = 0);

/// A part of the file.
struct byte_range {
  std::uint64_t first = 0, bytes = 0;
};

struct checkpoint_block {
  std::uint32_t version = checkpoint_version;
  std::uint32_t block_bytes = 0;    ///< 512 times a power of two, as HDF5 requires
  std::uint64_t file_bytes = 0;     ///< the whole file
  std::uint64_t rest_checksum = 0;  ///< of all bytes after this block outside of the ranges
  std::vector<byte_range> ranges;   ///< the rows of tables, from first to last
};

inline constexpr std::size_t checkpoint_block_head = 56;

[[nodiscard]] std::uint32_t block_bytes_for(std::size_t ranges);

[[nodiscard, gnu::cold]] byte_buffer compose_block(const checkpoint_block& b);

/// Reads such a block from the beginning of a file of `file_bytes`. Checks every number in it;
/// throws runtime_error with the second half of a sentence whose first half is the file's name.
[[nodiscard, gnu::cold]] checkpoint_block read_block(std::span<const std::byte> bytes,
                                                     std::uint64_t file_bytes);

/// Calls f(range) for the parts of the file after the block outside of the ranges.
template <class F>
void each_part_of_rest(const checkpoint_block& b, F&& f) {
  std::uint64_t at = b.block_bytes;
  for (const byte_range& r : b.ranges) {
    if (r.first > at) f(byte_range{at, r.first - at});
    at = r.first + r.bytes;
  }
  if (b.file_bytes > at) f(byte_range{at, b.file_bytes - at});
}

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_block_definitions.hpp"
#endif
