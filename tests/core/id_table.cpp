// Tables of ids: the number of each, and of none that was not added.
#include <doctest/doctest.h>

#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "talus/core/id_table.hpp"

using namespace talus;
using detail::id_table;

TEST_CASE("ids are found by their numbers in the order of insertion, others are unknown") {
  std::mt19937_64 random(3);
  for (const std::size_t n : {0u, 1u, 16u, 1000u}) {
    std::vector<system_id> ids;
    std::map<system_id, std::uint32_t> numbers;
    while (ids.size() < n) {
      const auto id = static_cast<system_id>(random() % (4 * n));  // some follow each other
      if (numbers.emplace(id, ids.size()).second) ids.push_back(id);
    }
    const id_table table(ids, [](system_id id) { return id; });
    bool right = true;
    for (std::uint64_t k = 0; k < 4 * n + 4; ++k) {
      const auto id = static_cast<system_id>(k);
      const auto at = numbers.find(id);
      right = right && table.has(id) == (at != numbers.end()) &&
              table.find(id) == (at == numbers.end() ? id_table::unknown : at->second);
    }
    CHECK(right);
  }
}

TEST_CASE("an id that is added twice is found by its first number") {
  id_table table;
  CHECK_FALSE(table.has(system_id{7}));
  table.reset(3);
  for (const std::uint64_t id : {7, 9, 7}) table.add(system_id{id});
  CHECK(table.find(system_id{7}) == 0);
  CHECK(table.find(system_id{9}) == 1);
}
