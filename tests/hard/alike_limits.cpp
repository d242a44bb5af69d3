// Islands at the limit of size, and on fixed bodies of one rank, with the reproducible solver: the
// same bits wherever the domains end.
#include <doctest/doctest.h>

#include <talus/world/state_of.hpp>

#include "alike.hpp"

using namespace talus;
using namespace talus::hard;

namespace {

/// Some of the heap lies on these.
template <class World>
void add_fixed_boxes(World& w) {
  const auto stone = w.material({.friction = 0.5});
  for (int k = 0; k < 9; ++k)
    w.add_if_local(body{.shape = box{{0.5, 0.5, 0.2}},
                        .position = {1.2 * (k % 3 - 1) + 0.1, 1.2 * (k / 3 - 1), 0.15},
                        .material = stone,
                        .fixed = true});
}
/// The digests of the ways to cut are those of one domain. `add` adds the bodies.
template <class Add>
std::uint64_t check_cuts(int steps, Add&& add) {
  std::string first;
  std::uint64_t solved = 0;
  for (const auto& cells : ways_to_cut) {
    INFO("domains ", cells[0], cells[1], cells[2]);
    const cut_result r = run_cut<alike<>>(cells, 2, 3, steps, add);
    if (first.empty()) first = r.digest, solved = r.islands;
    CHECK(r.digest == first);
    CHECK(r.islands == solved);
  }
  return solved;
}

}  // namespace

TEST_CASE("islands that pass the limit of size on one rank have the same bits on several") {
  const auto add = [](auto& w) {
    talus::detail::state_of(w).solver.limits = {.contacts = 40, .many = 30};
    mixed_heap(w);
  };
  CHECK(check_cuts(400, add) > 0);
}

TEST_CASE("islands on fixed bodies of one rank are solved with the same bits on several") {
  const auto heap = [](auto& w) { add_fixed_boxes(w), mixed_heap(w); };
  CHECK(check_cuts(300, heap) > 0);
  const auto small = [&](auto& w) {
    talus::detail::state_of(w).solver.limits = {.contacts = 40, .many = 30};
    heap(w);
  };
  CHECK(check_cuts(300, small) > 0);
}

TEST_CASE("a stack under a load of 1e4 times its density rests on a fixed body of one rank") {
  std::string first;
  for (const auto& cells : ways_to_cut) {
    INFO("domains ", cells[0], cells[1], cells[2]);
    const cut_result r = run_cut<alike<>>(cells, 2, 6.13, 240, [](auto& w) {
      const auto light = w.material({.density = 1, .friction = 0.5});
      const auto heavy = w.material({.density = 1e4, .friction = 0.5});
      w.add_if_local(body{
          .shape = box{{3, 3, 1}}, .position = {-0.9, 0.1, 0.5}, .material = light, .fixed = true});
      for (int k = 1; k < 6; ++k)
        w.add_if_local(body{.shape = box{{1, 1, 1}},
                            .position = {0.01, 0.013, k + 0.5},
                            .material = k == 5 ? heavy : light});
    });
    CHECK(r.overlap < 1e-9);
    CHECK(r.speed < 1e-7);
    CHECK(r.islands > 0);
    if (first.empty()) first = r.digest;
    CHECK(r.digest == first);
  }
}
