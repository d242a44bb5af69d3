#pragma once
// The definitions of checkpoint_block.hpp, in the compiled part or in each program.
#include "talus/io/detail/checkpoint_block.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::uint64_t checksum_of(std::span<const std::byte> bytes, std::uint64_t place) {
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

TALUS_HDF5_INLINE std::uint32_t block_bytes_for(std::size_t ranges) {
  std::uint32_t bytes = 512;
  while (bytes < checkpoint_block_head + 16 * ranges + 16) bytes *= 2;
  return bytes;
}

TALUS_HDF5_INLINE byte_buffer compose_block(const checkpoint_block& b) {
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

TALUS_HDF5_INLINE checkpoint_block read_block(std::span<const std::byte> bytes,
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

}  // namespace talus::detail
