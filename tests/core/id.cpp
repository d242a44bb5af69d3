#include "talus/core/id.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <set>
#include <unordered_set>

using namespace talus;

TEST_CASE("ids from sites, attempts and ranks never collide") {
  std::set<std::uint64_t> seen{value_of(no_id)};
  std::size_t made = 1;
  const std::vector<std::uint64_t> numbers{0, 1, 2, 63, 1000, (1ull << 32) - 1, (1ull << 38) - 1};
  for (const auto a : {0ull, 1ull, 7ull, 16383ull})
    for (const auto b : numbers) {
      seen.insert(value_of(detail::id_of_site(a, b)));
      seen.insert(value_of(detail::id_of_rank(a, b)));
      made += 2;
    }
  for (const auto n : numbers) {
    seen.insert(value_of(detail::id_of_attempt(n)));
    ++made;
  }
  CHECK(seen.size() == made);
}

TEST_CASE("ids made one after another sort in that order") {
  CHECK(detail::id_of_site(3, 4) < detail::id_of_site(3, 5));
  CHECK(detail::id_of_site(3, 5) < detail::id_of_site(4, 0));
  CHECK(detail::id_of_rank(1, 9) < detail::id_of_rank(2, 0));
  CHECK(detail::id_of_attempt(9) < no_id);
}

TEST_CASE("the mixing function is a bijection on what we can try, and spreads neighbours") {
  std::unordered_set<std::uint64_t> images;
  int flipped = 0;
  for (std::uint64_t x = 0; x < 10000; ++x) {
    images.insert(detail::mix(x));
    flipped += std::popcount(detail::mix(x) ^ detail::mix(x + 1));
  }
  CHECK(images.size() == 10000);
  CHECK(flipped / 10000.0 == doctest::Approx(32).epsilon(0.02));
}

TEST_CASE("ids are keys of hash tables") {
  std::unordered_set<system_id> ids;
  for (std::uint64_t i = 0; i < 100; ++i) ids.insert(detail::id_of_site(0, i % 50));
  CHECK(ids.size() == 50);
}
