// Disjoint sets: joined numbers have one root, the lowest or the one that comes first.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "talus/core/disjoint_sets.hpp"

using talus::detail::disjoint_sets;

TEST_CASE("the root of a set is its lowest number, in whatever order its parts were joined") {
  std::mt19937 random(5);
  for (const std::size_t n : {1u, 2u, 17u, 500u}) {
    disjoint_sets sets(n);
    std::vector<std::size_t> lowest(n);  // by the definition
    for (std::size_t i = 0; i < n; ++i) lowest[i] = i;
    for (std::size_t k = 0; k < n / 2; ++k) {
      const auto a = random() % n, b = random() % n;
      sets.join(a, b);
      const auto from = std::max(lowest[a], lowest[b]), to = std::min(lowest[a], lowest[b]);
      for (auto& x : lowest)
        if (x == from) x = to;
    }
    CHECK(sets.size() == n);
    bool same = true;
    for (std::size_t i = 0; i < n; ++i) same = same && sets.root(i) == lowest[i];
    CHECK(same);
  }
}

TEST_CASE("an order of one's own chooses the root, and a reset separates all") {
  disjoint_sets sets(6);
  const auto even_first = [](std::uint32_t x, std::uint32_t y) { return x % 2 < y % 2; };
  sets.join(1, 4, even_first), sets.join(3, 1, even_first);
  CHECK(sets.root(3) == 4);
  CHECK(sets.root(1) == 4);
  CHECK(sets.root(2) == 2);
  sets.reset(4);
  CHECK(sets.size() == 4);
  for (const std::uint32_t i : {0u, 1u, 2u, 3u}) CHECK(sets.root(i) == i);
}
