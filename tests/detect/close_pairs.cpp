// The pairs of a neighbour list that are within reach: those that a comparison of single pairs
// finds.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "talus/pairs/close_pairs.hpp"

using namespace talus;
using namespace talus::detail;

namespace {

struct ball {
  vec3 position{0, 0, 0};
  real reach = 0;
};
/// The rows of the two shapes of a pair may differ.
struct alignas(32) large_ball {
  vec3 position{0, 0, 0};
  real reach = 0;
  vec3 velocity{0, 0, 0};
};

}  // namespace

TEST_CASE("pairs within reach are found for lists of any length, and the others lose their place") {
  const unsigned seed = 1;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto between = [&](real low, real high) {
    return std::uniform_real_distribution<>(low, high)(random);
  };
  std::size_t found = 0, left_out = 0;
  for (std::size_t size = 0; size < 70; ++size) {
    std::vector<ball> a(20);
    std::vector<large_ball> b(30);
    for (auto& x : a) x = {{between(-1, 1), between(-1, 1), between(-1, 1)}, between(0.3, 0.6)};
    for (auto& x : b) x = {{between(-1, 1), between(-1, 1), between(-1, 1)}, between(0.3, 0.6), {}};
    std::vector<close_pair> pairs;
    for (std::size_t k = 0; k < size; ++k)
      pairs.push_back({static_cast<std::uint32_t>(random() % a.size()),
                       static_cast<std::uint32_t>(random() % b.size()),
                       static_cast<history_place>(k)});
    std::vector<std::uint32_t> close(size + 1);
    const std::size_t count = find_close(pairs.data(), size, a.data(), b.data(), close.data());
    std::size_t next = 0;
    for (std::size_t k = 0; k < size; ++k) {
      const ball& x = a[pairs[k].i];
      const large_ball& y = b[pairs[k].j];
      const real reach = x.reach + y.reach;
      if ((x.position - y.position).squaredNorm() > reach * reach) {
        CHECK(pairs[k].last == history_place::none);
        ++left_out;
        continue;
      }
      CHECK(pairs[k].last == static_cast<history_place>(k));
      REQUIRE(next < count);
      CHECK(close[next++] == k);
      ++found;
    }
    CHECK(next == count);
  }
  CHECK(found > 100);
  CHECK(left_out > 100);
}
