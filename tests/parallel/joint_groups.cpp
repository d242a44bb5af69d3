// Ranks find the islands of joints that they share, whatever the graph of the parts of these.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>
#include <talus/core/disjoint_sets.hpp>
#include <talus/ghosts/joint_groups.hpp>
#include <talus/parallel/threads.hpp>
#include <utility>
#include <vector>

using namespace talus;

TEST_CASE("all ranks of an island agree on its name and its ranks") {
  for (unsigned seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto below = [&](std::size_t n) { return random() % n; };
    const std::size_t ranks = 2 + below(6), parts = 1 + below(5);  // of each rank
    const std::size_t all = ranks * parts, joints = below(2 * all);
    // Part p is on rank p % ranks; some islands are long rows of parts.
    std::vector<std::pair<std::size_t, std::size_t>> edges;
    for (std::size_t k = 0; k < joints; ++k) {
      const std::size_t a = below(all);
      const std::size_t b = seed % 2 == 0 ? (a + 1) % all : below(all);
      if (a % ranks != b % ranks) edges.push_back({a, b});
    }
    detail::disjoint_sets sets(all);
    std::vector<char> joined(all, 0);
    for (const auto& [a, b] : edges) sets.join(a, b), joined[a] = joined[b] = 1;
    const auto id_of_part = [](std::size_t p) { return system_id{1000 + p}; };
    const auto id_of_end = [&](std::size_t edge, bool first) {
      return system_id{5000 + 2 * edge + first};
    };

    threads::launch({.ranks = static_cast<int>(ranks)}, [&](threads::link& link) {
      const auto own = static_cast<std::size_t>(link.rank());
      detail::plain_vector<system_id> names;
      for (std::size_t p = own; p < all; p += ranks) names.push_back(id_of_part(p));
      detail::plain_vector<detail::joint_groups<void>::border> borders;
      for (std::size_t k = 0; k < edges.size(); ++k)
        for (const bool first : {true, false}) {
          const std::size_t here = first ? edges[k].first : edges[k].second,
                            there = first ? edges[k].second : edges[k].first;
          if (here % ranks == own)
            borders.push_back({static_cast<std::uint32_t>(here / ranks),
                               static_cast<std::int32_t>(there % ranks), id_of_end(k, first),
                               id_of_end(k, !first)});
        }
      detail::joint_groups<void> groups;
      groups.find(link.rank(), names, borders, [&](std::vector<neighbour_message>& messages) {
        link.start(messages);
        link.finish(messages);
      });
      for (std::size_t p = own; p < all; p += ranks) {
        const std::int32_t g = groups.group_of(static_cast<std::uint32_t>(p / ranks));
        CHECK((g >= 0) == (joined[p] != 0));
        if (g < 0) continue;
        std::set<int> expected;
        for (std::size_t q = 0; q < all; ++q)
          if (sets.root(q) == sets.root(p)) expected.insert(static_cast<int>(q % ranks));
        const auto& group = groups.groups()[static_cast<std::size_t>(g)];
        CHECK(group.name == id_of_part(sets.root(p)));
        CHECK(std::set<int>(group.ranks.begin(), group.ranks.end()) == expected);
      }
    });
  }
}
