// Colours that depend on ids alone: on two ranks as on one, and no two alike at one body.
#include <doctest/doctest.h>

#include <barrier>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <talus/solver/colouring.hpp>
#include <thread>

using namespace talus::detail;
using talus::system_id;

namespace {

using pairs = std::set<std::pair<int, int>>;
using colours = std::map<std::pair<int, int>, std::uint32_t>;

/// Rank 0 owns the bodies below `cut`, rank 1 the others; each has the pairs of its own bodies.
/// With `forgets` rank 1 has lost one pair that both share.
colours colours_of(const pairs& all, int bodies, int cut, bool forgets = false) {
  std::array<colouring, 2> ranks;
  std::array<bool, 2> complained{};
  std::barrier<> both(2);
  const auto owner = [&](int body) { return body < cut ? 0 : 1; };
  const auto work = [&](int rank) {
    colouring& c = ranks[static_cast<std::size_t>(rank)];
    if (cut < bodies) c.lines.resize(1);
    c.start(static_cast<std::size_t>(bodies));
    for (const auto& [i, j] : all) {
      const bool mine_i = owner(i) == rank, mine_j = owner(j) == rank;
      if (!mine_i && !mine_j) continue;
      if (forgets && rank == 1 && mine_i != mine_j) {
        forgets = false;
        continue;
      }
      const contact_key key{system_id(i), system_id(j), 0};
      c.add({.priority = key.hash(),
             .id_a = key.a,
             .id_b = key.b,
             .a = mine_i ? i : j,
             .b = mine_i ? j : i,
             .line = mine_i != mine_j ? 0 : -1});
    }
    try {
      c.colour([&](bool) {
        both.arrive_and_wait();
        if (rank == 0) std::swap(ranks[0].lines[0].out, ranks[1].lines[0].in);
        if (rank == 1) std::swap(ranks[1].lines[0].out, ranks[0].lines[0].in);
        both.arrive_and_wait();
      });
    } catch (const std::runtime_error&) {
      complained[static_cast<std::size_t>(rank)] = true;
    }
  };
  if (cut == bodies) {
    work(0);
  } else {
    std::thread other(work, 1);
    work(0);
    other.join();
  }
  CHECK(complained[0] == complained[1]);
  if (complained[0]) return {};
  colours found;
  for (const colouring& c : ranks)
    for (std::size_t n = 0; n < c.size(); ++n) {
      const auto ids =
          std::pair(static_cast<int>(c.unit(n).id_a), static_cast<int>(c.unit(n).id_b));
      const auto [at, fresh] = found.emplace(ids, c.colour_of(n));
      if (!fresh) CHECK(at->second == c.colour_of(n));  // both ranks of a shared pair
    }
  return found;
}

pairs random_pairs(std::mt19937_64& random, int bodies, int count) {
  pairs all;
  while (static_cast<int>(all.size()) < count) {
    const int i = static_cast<int>(random() % static_cast<unsigned>(bodies));
    const int j = static_cast<int>(random() % static_cast<unsigned>(bodies));
    if (i < j) all.insert({i, j});
  }
  return all;
}

}  // namespace

TEST_CASE("two ranks find the colours of one, and no body has a colour twice") {
  std::mt19937_64 random(20261122);
  for (int run = 0; run < 60; ++run) {
    CAPTURE(run);
    const int bodies = 5 + static_cast<int>(random() % 60);
    pairs all = random_pairs(random, bodies, std::min(bodies * 3, bodies * (bodies - 1) / 2));
    const colours alone = colours_of(all, bodies, bodies);
    REQUIRE(alone.size() == all.size());
    std::set<std::pair<int, std::uint32_t>> taken;
    for (const auto& [ids, colour] : alone) {
      CHECK(taken.insert({ids.first, colour}).second);
      CHECK(taken.insert({ids.second, colour}).second);
    }
    CHECK(colours_of(all, bodies, bodies / 2) == alone);
  }
}

TEST_CASE("a body with hundreds of contacts gets as many colours, on two ranks too") {
  pairs star;
  for (int k = 1; k < 300; ++k) star.insert({0, k});
  for (int k = 1; k + 1 < 300; ++k) star.insert({k, k + 1});
  const colours alone = colours_of(star, 300, 300);
  std::set<std::uint32_t> at_hub;
  for (const auto& [ids, colour] : alone)
    if (ids.first == 0) at_hub.insert(colour);
  CHECK(at_hub.size() == 299);
  CHECK(colours_of(star, 300, 100) == alone);
}

TEST_CASE("ranks that do not have the same pairs say so, both of them") {
  std::mt19937_64 random(7);
  CHECK(colours_of(random_pairs(random, 40, 100), 40, 20, true).empty());
}
