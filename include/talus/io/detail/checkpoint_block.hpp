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
[[nodiscard]] inline std::uint64_t checksum_of(std::span<const std::byte> bytes,
                                               std::uint64_t place = 0) {
  constexpr std::uint64_t golden = 0x9e3779b97f4a7c15ull;
  std::uint64_t sum = mix(bytes.size() ^ place), salt = place * 0xd1342543de82ef95ull + golden;
  const std::size_t words = bytes.size() / 8;
  const std::byte* at = bytes.data();
  for (std::size_t i = 0; i < words; ++i, at += 8, salt += golden) {
    std::uint64_t word;
    std::memcpy(&word, at, 8);
    sum += mix(word ^ salt);
  }
  if (const std::size_t rest = bytes.size() % 8; rest != 0) {
    std::uint64_t word = 0;
    std::memcpy(&word, at, rest);
    sum += mix(word ^ salt);
  }
  return sum;
}

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

[[nodiscard]] inline std::uint32_t block_bytes_for(std::size_t ranges) {
  std::uint32_t bytes = 512;
  while (bytes < checkpoint_block_head + 16 * ranges + 16) bytes *= 2;
  return bytes;
}

[[nodiscard, gnu::cold]] inline byte_buffer compose_block(const checkpoint_block& b) {
  byte_buffer bytes;
  byte_writer out(bytes);
  for (const char c : checkpoint_mark) out.put(c);
  while (bytes.size() < 32) out.put('\0');
  out.put(b.version);
  out.put(b.block_bytes);
  out.put(b.file_bytes);
  out.put(static_cast<std::uint64_t>(b.ranges.size()));
  for (const byte_range& r : b.ranges) out.put(r.first), out.put(r.bytes);
  out.put(b.rest_checksum);
  bytes.resize(b.block_bytes);
  const std::uint64_t sum = checksum_of(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(bytes.data() + bytes.size() - 8, &sum, 8);
  return bytes;
}

/// Reads such a block from the beginning of a file of `file_bytes`. Checks every number in it;
/// throws runtime_error with the second half of a sentence whose first half is the file's name.
[[nodiscard, gnu::cold]] inline checkpoint_block read_block(std::span<const std::byte> bytes,
                                                            std::uint64_t file_bytes) {
  if (bytes.size() < checkpoint_mark.size() ||
      std::memcmp(bytes.data(), checkpoint_mark.data(), checkpoint_mark.size()) != 0)
    throw std::runtime_error("is no checkpoint of talus, or its first bytes are damaged");
  if (bytes.size() < checkpoint_block_head + 16)
    throw std::runtime_error("is damaged: it ends within its first block");
  byte_reader in(bytes.subspan(32));
  checkpoint_block b;
  b.version = in.get<std::uint32_t>();
  b.block_bytes = in.get<std::uint32_t>();
  b.file_bytes = in.get<std::uint64_t>();
  const auto ranges = in.get<std::uint64_t>();
  if (b.block_bytes < 512 || b.block_bytes > (1u << 26) || b.block_bytes > file_bytes)
    throw std::runtime_error("is damaged: its first block makes no sense");
  if (bytes.size() < b.block_bytes)
    throw std::runtime_error("is damaged: it ends within its first block");
  bytes = bytes.first(b.block_bytes);
  std::uint64_t sum = 0;
  std::memcpy(&sum, bytes.data() + bytes.size() - 8, 8);
  if (sum != checksum_of(bytes.first(bytes.size() - 8)))
    throw std::runtime_error("is damaged: the checksum of its first block is wrong");
  if (b.version > checkpoint_version)
    fail<std::runtime_error>(
        "is of format {}, but this program reads formats up to {}: build it with a newer talus",
        b.version, checkpoint_version);
  if (b.file_bytes != file_bytes)
    fail<std::runtime_error>("is damaged: it has {} bytes, but was written with {}", file_bytes,
                             b.file_bytes);
  if (ranges > (b.block_bytes - checkpoint_block_head - 16) / 16)
    throw std::runtime_error("is damaged: its first block makes no sense");
  std::uint64_t end = b.block_bytes;
  for (std::uint64_t k = 0; k < ranges; ++k) {
    byte_range r;
    r.first = in.get<std::uint64_t>();
    r.bytes = in.get<std::uint64_t>();
    if (r.first < end || r.first > file_bytes || r.bytes > file_bytes - r.first)
      throw std::runtime_error("is damaged: its first block makes no sense");
    end = r.first + r.bytes;
    b.ranges.push_back(r);
  }
  b.rest_checksum = in.get<std::uint64_t>();
  return b;
}

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
