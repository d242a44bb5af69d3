#include "talus/core/bytes.hpp"

#include <doctest/doctest.h>

using namespace talus;
using detail::byte_buffer;
using detail::byte_reader;
using detail::byte_writer;

TEST_CASE("what is written is read back in the same order, bit for bit") {
  const quat turn = rotation({1, 2, 3}, 0.7);
  const std::vector<real> reals{0.1, -0.0, 1e-310, std::numeric_limits<real>::infinity()};
  byte_buffer buffer;
  byte_writer out(buffer);
  out.put(std::uint8_t{7});
  out.put(vec3(0.1, 0.2, 0.3));
  out.put(turn);
  out.put(std::span<const real>(reals));
  out.put(std::int64_t{-5});

  byte_reader in(buffer);
  CHECK(in.get<std::uint8_t>() == 7);
  CHECK(in.get<vec3>() == vec3(0.1, 0.2, 0.3));
  CHECK(in.get<quat>().coeffs() == turn.coeffs());
  const auto read = in.get_all<real>();
  REQUIRE(read.size() == reals.size());
  CHECK(std::memcmp(read.data(), reals.data(), sizeof(real) * reals.size()) == 0);
  CHECK_FALSE(in.empty());
  CHECK(in.get<std::int64_t>() == -5);
  CHECK(in.empty());
}

TEST_CASE("a writer appends to what the buffer holds, without padding") {
  byte_buffer buffer;
  byte_writer(buffer).put(char{'a'});
  byte_writer(buffer).put(real{2});
  CHECK(buffer.size() == 1 + sizeof(real));
  byte_reader in(buffer);
  CHECK(in.get<char>() == 'a');
  CHECK(in.get<real>() == 2);
}

TEST_CASE("an empty list travels") {
  byte_buffer buffer;
  byte_writer(buffer).put(std::span<const vec3>{});
  byte_reader in(buffer);
  CHECK(in.get_all<vec3>().empty());
  CHECK(in.empty());
}

TEST_CASE("reading past the end throws") {
  byte_buffer buffer;
  byte_writer(buffer).put(std::int32_t{1});
  byte_reader in(buffer);
  CHECK_THROWS_WITH_AS(in.get<real>(), "a message ended before its content", std::runtime_error);
  CHECK(in.get<std::int32_t>() == 1);
  CHECK_THROWS_AS(in.get<char>(), std::runtime_error);
}

TEST_CASE("a list cut short throws") {
  const std::vector<real> reals{1, 2, 3};
  byte_buffer buffer;
  byte_writer(buffer).put(std::span<const real>(reals));
  buffer.resize(buffer.size() - 1);
  byte_reader in(buffer);
  CHECK_THROWS_AS(in.get_all<real>(), std::runtime_error);
}

TEST_CASE("only plain values travel") {
  CHECK(detail::plain_bytes<real>);
  CHECK(detail::plain_bytes<vec3>);
  CHECK(detail::plain_bytes<mat3>);
  CHECK(detail::plain_bytes<quat>);
  CHECK_FALSE(detail::plain_bytes<std::string>);
  CHECK_FALSE(detail::plain_bytes<std::pair<int, int>>);  // its assignment is its own
  CHECK_FALSE(detail::plain_bytes<int*>);
}
