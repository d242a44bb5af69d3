// Messages of run() about bodies that start inside each other: of thin ones too, once, and by the
// place where they were put.
#include <doctest/doctest.h>

#include <mutex>
#include <string>
#include <talus/observe/initial_overlap.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/shape/capsule.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>
#include <type_traits>

using namespace talus;

namespace {

using pair = union_of<sphere>;
using scene = scenario<bodies<sphere, box, capsule, pair, plane>, transport<threads>,
                       decomposition<grid<dynamic>>>;
using ring =
    scenario<bodies<sphere>, transport<threads>, decomposition<periodic<grid<dynamic>, along::x>>>;

/// All output of all ranks about the bodies that set_up(world) adds between 0 and 12 along x.
template <class Scenario, class SetUp>
std::string told(SetUp&& set_up, int ranks = 3) {
  std::string all;
  std::mutex one_by_one;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link);
    const grid<dynamic> cells{.lower = {0}, .upper = {12}};
    if constexpr (std::is_same_v<Scenario, ring>)
      w.decompose({cells});
    else
      w.decompose(cells);
    w.material({});
    set_up(w);
    w.synchronize();
    const std::string words = detail::initial_overlap(w);
    const std::scoped_lock lock(one_by_one);
    all += words;
  });
  return all;
}
template <class First, class Second>
std::string of_two(First first, vec3 at, Second second, vec3 there, quat turned = {1, 0, 0, 0}) {
  return told<scene>([&](auto& w) {
    w.add_if_local(body<First>{.shape = first, .position = at});
    w.add_if_local(body<Second>{.shape = second, .position = there, .orientation = turned});
  });
}
bool has(const std::string& text, const char* words) { return text.find(words) != text.npos; }

}  // namespace

TEST_CASE("cards and rods inside each other are told by their thickness") {
  const box card{{1, 0.6, 0.02}};
  CHECK(has(of_two(card, {4, 0, 0}, card, {4, 0, 0}), "deep in the box"));
  CHECK(of_two(card, {4, 0, 0}, card, {4, 0, 0.0195}).empty());  // by a twentieth
  const capsule rod{0.05, 2};
  CHECK(has(of_two(rod, {4, 0, 0}, rod, {4, 0, 0.02}, rotation({1, 0, 0}, pi / 2)),
            "deep in the capsule"));
  CHECK(of_two(rod, {4, 0, 0}, rod, {4, 0.1, 0}).empty());
  const pair two({{sphere{0.5}, {{-0.4, 0, 0}}}, {sphere{0.1}, {{0.6, 0, 0}}}});
  CHECK(has(of_two(two, {4, 0, 0}, sphere{0.5}, {4, 0.9, 0}), "deep in the"));
}

TEST_CASE("of pairs on several ranks that are as deep one is told") {
  const std::string words = told<scene>([](auto& w) {
    for (const real x : {1, 5, 9})  // a rank for each
      for (const real y : {0.0, 0.5})
        w.add_if_local(body{.shape = sphere{0.5}, .position = {x, y, 0}});
  });
  CHECK(has(words, "begins 0.5 deep"));
  CHECK(words.find("begins") == words.rfind("begins"));
}

TEST_CASE("a card under the floor is told, and one that lies on it is not") {
  const auto on_floor = [](real height) {
    return told<scene>([&](auto& w) {
      w.global([&](auto& scope) { scope.add(body<plane>{.shape = plane{}}); });
      w.add_if_local(body{.shape = box{{1, 0.6, 0.02}}, .position = {7, 0, height}});
    });
  };
  CHECK(has(on_floor(-0.005), "at (7, 0, -0.005) begins 0.015 deep in the plane"));
  CHECK(on_floor(0.01).empty());
}

TEST_CASE("over the side of a periodic box the place that is told is in the box") {
  for (const int ranks : {1, 3}) {
    const std::string words = told<ring>(
        [](auto& w) {
          w.add_if_local(body{.shape = sphere{0.5}, .position = {0.2, 0, 1}});
          w.add_if_local(body{.shape = sphere{0.5}, .position = {11.7, 0, 1}});
        },
        ranks);
    CHECK(has(words, "begins 0.5 deep in the sphere"));
    const bool there = has(words, "at (0.2, 0, 1)") || has(words, "at (11.7, 0, 1)");
    CHECK_MESSAGE(there, words);
    CHECK(words.find("begins") == words.rfind("begins"));
  }
}
