// Ranks that compute the same contact find the same impulse: otherwise momentum would be lost.
#include <doctest/doctest.h>

#include <array>
#include <map>
#include <mutex>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>

#include "../scenes/solids.hpp"

using namespace talus;

namespace {

using fast_column = scenario<bodies<box, sphere, plane>, features<continuous_collision>,
                             transport<threads>, decomposition<grid<dynamic, dynamic, dynamic>>>;

/// The results of a scene on two ranks that meet at z = `cut`.
struct agreement {
  std::uint64_t shared = 0;  ///< contacts that both ranks computed, over all steps
  real furthest_apart = 0;   ///< two impulses of such a contact
};

template <class Scenario, class SetUp>
agreement across(real cut, int steps, SetUp&& set_up) {
  using key = std::array<std::uint64_t, 3>;
  agreement found;
  std::array<std::map<key, vec3>, 2> impulses;
  const grid<dynamic, dynamic, dynamic> halves{
      .cells = {1, 1, 2}, .lower = {-9, -9, cut - 20}, .upper = {9, 9, cut + 20}};
  threads::launch({.ranks = 2}, [&](threads::link& link) {
    world<Scenario> w(link, halves);
    w.gravity({0, 0, -9.81});
    w.material({.friction = 0.5});
    w.global([&](auto& s) { s.add(plane{.normal = {0, 0, 1}}, {}); });
    set_up(w);
    w.synchronize();
    for (int k = 0; k < steps; ++k) {
      w.step(1.0 / 240);
      auto& own = impulses[static_cast<std::size_t>(link.rank())];
      own.clear();
      for (const auto& c : talus::detail::state_of(w).history.entries())
        own[{value_of(c.key.a), value_of(c.key.b), c.key.feature}] = c.memory;
      link.barrier();
      if (link.rank() == 0)
        for (const auto& [at, impulse] : impulses[0])
          if (const auto other = impulses[1].find(at); other != impulses[1].end()) {
            ++found.shared;
            found.furthest_apart = std::max(found.furthest_apart, (impulse - other->second).norm());
          }
      link.barrier();
    }
  });
  return found;
}

void check_agreed(const agreement& found) {
  CHECK(found.shared > 50);
  CHECK(found.furthest_apart < 1e-13);  // weights are about 10, and a step takes 1/240
}

}  // namespace

TEST_CASE("two ranks agree on the impulses of a column that stands across their boundary") {
  check_agreed(across<scenes::solids>(1, 60, [](auto& w) {
    for (int k = 0; k < 3; ++k)
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, 0, k + 0.5}});
  }));
}

TEST_CASE("two ranks agree on the impulses of a column of fast bodies across their boundary") {
  check_agreed(across<fast_column>(1, 60, [](auto& w) {
    w.add_if_local(body{.shape = sphere{0.5}, .position = {0, 0, 0.5}});
    w.add_if_local(body{.shape = sphere{0.5}, .position = {0.3, 0, 1.35}, .velocity = {0, 0, -3}});
  }));
}

TEST_CASE("two ranks agree on the impulses of a column that stands on a body fixed beyond reach") {
  check_agreed(across<scenes::solids>(4, 60, [](auto& w) {
    for (int k = 0; k < 3; ++k)
      w.add_if_local(body{.shape = sphere{0.5},
                          .position = {0.02 * k, 0.01 * k, 2.5 + 0.999 * k},
                          .velocity = {0.1 * k, 0, 0},
                          .fixed = k == 0});
  }));
}
