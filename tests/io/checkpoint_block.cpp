// The first block of a checkpoint: all its bytes are checked, for any content.
#include <doctest/doctest.h>

#include <cstring>
#include <random>
#include <string>
#include <talus/io/detail/checkpoint_block.hpp>

using namespace talus;
using namespace talus::detail;

namespace {

constexpr std::uint64_t file_bytes = 100'000;

checkpoint_block some_block() {
  checkpoint_block b;
  b.ranges = {{2048, 500}, {2548, 0}, {5000, 95'000}};
  b.block_bytes = block_bytes_for(b.ranges.size());
  b.file_bytes = file_bytes;
  b.rest_checksum = 0x123456789abcdef0;
  return b;
}
std::string refusal(const byte_buffer& bytes, std::uint64_t length = file_bytes) {
  try {
    (void)read_block(bytes, length);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}
/// With valid checksums of these bytes.
void seal(byte_buffer& bytes) {
  const std::uint64_t sum = checksum_of(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(bytes.data() + bytes.size() - 8, &sum, 8);
}

}  // namespace

TEST_CASE("a block is read as it was composed, and the rest is what its ranges leave") {
  const checkpoint_block b = some_block(), r = read_block(compose_block(b), file_bytes);
  CHECK(r.block_bytes == 512);
  CHECK(r.ranges.size() == 3);
  CHECK(r.ranges[2].first == 5000);
  CHECK(r.rest_checksum == b.rest_checksum);
  std::uint64_t rest = 0;
  each_part_of_rest(r, [&](byte_range part) { rest += part.bytes; });
  CHECK(rest == file_bytes - 512 - 500 - 95'000);
  for (const std::size_t ranges : {0, 27, 28, 29, 1000}) {
    checkpoint_block many;
    for (std::size_t k = 0; k < ranges; ++k) many.ranges.push_back({70'000 + k, 1});
    many.block_bytes = block_bytes_for(ranges);
    many.file_bytes = file_bytes;
    CHECK(read_block(compose_block(many), file_bytes).ranges.size() == ranges);
  }
}

TEST_CASE("no bit of a block may change, and none of it may be missing") {
  const byte_buffer good = compose_block(some_block());
  CHECK(refusal(good).empty());
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    byte_buffer bad = good;
    bad[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    if (refusal(bad).empty()) FAIL_CHECK("bit " << bit << " changed, and nobody noticed");
  }
  for (std::size_t length = 0; length < good.size(); ++length) {
    const byte_buffer part(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length));
    if (refusal(part, length).empty()) FAIL_CHECK(length << " bytes were enough");
  }
  CHECK(refusal(good, file_bytes - 1) ==
        "is damaged: it has 99999 bytes, but was written with 100000");
}

TEST_CASE("a newer format is refused by its number") {
  checkpoint_block b = some_block();
  b.version = checkpoint_version + 1;
  CHECK(refusal(compose_block(b)) ==
        "is of format 2, but this program reads formats up to 1: build it with a newer talus");
}

TEST_CASE("blocks with a right checksum and any content are read or refused, and nothing else") {
  std::mt19937_64 random(1);
  int read = 0;
  for (int n = 0; n < 200'000; ++n) {
    checkpoint_block b = some_block();
    if (random() % 4 == 0) b.ranges.resize(random() % 28);
    byte_buffer bytes = compose_block(b);
    for (std::uint64_t changes = random() % 4; changes > 0; --changes) {
      // Relevant numbers, mostly near their correct values.
      const std::size_t at = 32 + 4 * (random() % 24);
      std::uint64_t value = random() >> random() % 64;
      std::memcpy(bytes.data() + at, &value, 4 + 4 * (random() % 2));
    }
    seal(bytes);
    const std::uint64_t length = random() % 8 == 0 ? random() % 200'000 : file_bytes;
    try {
      const checkpoint_block r = read_block(bytes, length);
      std::uint64_t end = r.block_bytes;
      each_part_of_rest(r, [&](byte_range part) { end = part.first + part.bytes; });
      CHECK(end <= length);
      for (const byte_range& range : r.ranges) CHECK(range.first + range.bytes <= length);
      ++read;
    } catch (const std::runtime_error&) {
    }
  }
  CHECK(read > 1000);
}

TEST_CASE("a checksum notices each bit, the length, and what has changed places") {
  byte_buffer bytes(61);
  std::mt19937 random(2);
  for (std::byte& b : bytes) b = static_cast<std::byte>(random());
  const std::uint64_t sum = checksum_of(bytes);
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    byte_buffer bad = bytes;
    bad[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    CHECK(checksum_of(bad) != sum);
  }
  byte_buffer turned = bytes;
  for (int k = 0; k < 8; ++k)
    std::swap(turned[static_cast<std::size_t>(k)], turned[static_cast<std::size_t>(k + 16)]);
  CHECK(checksum_of(turned) != sum);
  CHECK(checksum_of(bytes, 1) != sum);
  bytes.push_back(std::byte{0});
  CHECK(checksum_of(bytes) != sum);
}
