// A world has the same results with every broad phase.
#include <doctest/doctest.h>

#include <string>
#include <talus/detect/sweep_and_prune.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>
#include <type_traits>

#include "../scenes/reproduced.hpp"

using namespace talus;

namespace {

using swept = scenario<bodies<sphere, box, plane>, solver<reproducible>, transport<threads>,
                       broad_phase<sweep_and_prune>, decomposition<any_decomposition>>;

template <class Method>
std::string digest_of(int ranks) {
  constexpr bool usual = std::is_same_v<Method, linear_hash_grid>;
  using scene = std::conditional_t<usual, scenes::reproduced, swept>;
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<scene> w(link);
    w.decompose(grid<dynamic, dynamic>{.lower = {-5, -5}, .upper = {5, 5}}, {.distance = 3});
    const auto stone = w.material({.density = 1, .friction = 0.5});
    w.gravity({0, 0, -9.81});
    w.global([&](auto& scope) {
      scope.add(plane{}, stone);
      scope.add(box{{1, 1, 1}}, stone, {0.2, 0.1, 0.5});
    });
    for (int i = 0; i < 100; ++i) {
      const vec3 at{i % 5 - 2., i / 5 % 5 - 2.1, 2 + 1.1 * (i / 25)};
      const real size = 0.3 + 0.02 * (i % 7);
      if (i % 3 == 0)
        w.add_if_local(body{.shape = box{{size, size, size}}, .position = at, .material = stone});
      else
        w.add_if_local(body{.shape = sphere{size}, .position = at, .material = stone});
    }
    for (int k = 0; k < 120; ++k) w.step(0.005);
    const std::string d = state_digest(w);
    if (link.rank() == 0) digest = d;
  });
  return digest;
}

}  // namespace

TEST_CASE("a reproducible run has the same bits with every broad phase, on any ranks") {
  const std::string wanted = digest_of<linear_hash_grid>(1);
  CHECK(digest_of<sweep_and_prune>(1) == wanted);
  CHECK(digest_of<sweep_and_prune>(4) == wanted);
}
