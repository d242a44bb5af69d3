// The laws of every broad phase: exactly the pairs that a search over all pairs finds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "../generator.hpp"
#include "talus/concepts.hpp"
#include "talus/detect/hash_grid.hpp"
#include "talus/detect/sweep_and_prune.hpp"

namespace {

using namespace talus;
using pair_list = std::vector<std::pair<std::size_t, std::size_t>>;

struct cloud {
  std::vector<vec3> centres;
  std::vector<real> reaches;
};

bool touch(const cloud& a, std::size_t i, const cloud& b, std::size_t j) {
  const vec3 d = a.centres[i] - b.centres[j];
  const real sum = a.reaches[i] + b.reaches[j];
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= sum * sum;
}
template <class Search>
Search built(const cloud& c) {
  Search s;
  s.build(c.centres, c.reaches);
  return s;
}

template <class Search>
void check_laws(const cloud& a, const cloud& b) {
  const Search of_a = built<Search>(a), of_b = built<Search>(b);
  REQUIRE(of_a.size() == a.centres.size());
  const auto sorted = [](pair_list all) {
    std::sort(all.begin(), all.end());
    return all;
  };
  pair_list wanted, found, again;
  for (std::size_t i = 0; i < a.centres.size(); ++i)
    for (std::size_t j = i + 1; j < a.centres.size(); ++j)
      if (touch(a, i, a, j)) wanted.push_back({i, j});
  of_a.pairs([&](std::size_t i, std::size_t j) { found.push_back(std::minmax(i, j)); });
  built<Search>(a).pairs([&](std::size_t i, std::size_t j) { again.push_back(std::minmax(i, j)); });
  CHECK(found == again);  // the order depends on the input alone
  CHECK(sorted(found) == wanted);

  wanted.clear(), found.clear();
  for (std::size_t i = 0; i < a.centres.size(); ++i)
    for (std::size_t j = 0; j < b.centres.size(); ++j)
      if (touch(a, i, b, j)) wanted.push_back({i, j});
  of_a.pairs_with(of_b, [&](std::size_t i, std::size_t j) { found.push_back({i, j}); });
  CHECK(sorted(found) == wanted);

  for (std::size_t j = 0; j < std::min<std::size_t>(20, b.centres.size()); ++j) {
    pair_list near, hits;
    for (std::size_t i = 0; i < a.centres.size(); ++i)
      if (touch(a, i, b, j)) near.push_back({i, j});
    of_a.query(b.centres[j], b.reaches[j], [&](std::size_t i) { hits.push_back({i, j}); });
    CHECK(sorted(hits) == near);
  }
}

cloud random_cloud(generator& random, int n, real smallest, real edge, const vec3& squash,
                   const vec3& origin) {
  cloud c;
  for (int i = 0; i < n; ++i) {
    c.reaches.push_back(std::pow(smallest, random(0, 1)));
    c.centres.push_back(origin + random.point(edge).cwiseProduct(squash));
  }
  return c;
}

}  // namespace

TEST_CASE_TEMPLATE("a broad phase finds exactly the pairs that touch", Search, hash_grid,
                   sorted_balls) {
  static_assert(concepts::pair_search<Search>);
  for (const std::uint64_t seed : {1, 2, 3})
    for (const real smallest : {1., 0.1, 1e-3})
      for (const real edge : {3., 10., 300.})
        for (const vec3& squash : {vec3(1, 1, 1), vec3(0, 0, 1), vec3(1, 0, 1)})
          for (const real far : {0., 1e6}) {
            CAPTURE(seed);
            CAPTURE(smallest);
            CAPTURE(edge);
            CAPTURE(far);
            generator random{std::mt19937_64(seed)};
            const vec3 origin(far, -far, far);
            check_laws<Search>(random_cloud(random, 150, smallest, edge, squash, origin),
                               random_cloud(random, 60, smallest, edge, squash, origin));
          }
}

TEST_CASE_TEMPLATE("balls that just touch are found, wherever they lie", Search, hash_grid,
                   sorted_balls) {
  for (const real shift : {0., 0.1, -1. / 3, 1e6}) {
    cloud lattice;
    for (int i = 0; i < 125; ++i) {
      lattice.centres.push_back(vec3(i % 5, i / 5 % 5, i / 25) + vec3(shift, -shift, 0.5 * shift));
      lattice.reaches.push_back(0.5);
    }
    CAPTURE(shift);
    check_laws<Search>(lattice, lattice);
  }
}

TEST_CASE_TEMPLATE("a broad phase names the body that is nowhere, and serves no bodies too", Search,
                   hash_grid, sorted_balls) {
  const real none = std::numeric_limits<real>::quiet_NaN();
  const auto refused = [](const cloud& c) -> std::size_t {
    try {
      built<Search>(c);
    } catch (const unplaceable& e) {
      return e.index;
    }
    return 99;
  };
  CHECK(refused({{{0, 0, 0}, {0, none, 0}}, {1, 1}}) == 1);
  CHECK(refused({{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {1, 1, -1}}) == 2);
  CHECK(refused({{{0, 0, 0}, {0, 0, 1e300}}, {1, 1}}) == 1);
  CHECK(refused({{{0, 0, 0}, {0, 0, 3}}, {1, 1}}) == 99);
  const Search empty = built<Search>({});
  CHECK(empty.size() == 0);
  empty.pairs([](std::size_t, std::size_t) { FAIL("a pair of nothing"); });
  empty.query({0, 0, 0}, 1, [](std::size_t) { FAIL("nothing touches"); });
}
