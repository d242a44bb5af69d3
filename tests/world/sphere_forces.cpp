// Forces between spheres, eight contacts at once: worlds reach the same bits as with a law whose
// contacts are evaluated one by one, and with momentum balance; with several materials and fixed
// bodies, over ranks and through periodic faces.
#include <doctest/doctest.h>

#include <array>
#include <map>
#include <mutex>
#include <talus/interaction/central_attractions.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

using cells = grid<dynamic, dynamic>;
template <class Decomposition, class... Features>
using heap = scenario<bodies<sphere, plane>,
                      soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance>,
                      decomposition<Decomposition>, features<Features...>>;
/// With a cohesion that no material has: contacts are evaluated one by one.
template <class Decomposition>
using heap_by_one =
    scenario<bodies<sphere, plane>,
             soft_contact<hertz_mindlin, coulomb_friction, rolling_resistance, linear_cohesion>,
             decomposition<Decomposition>>;

template <class Decomposition>
constexpr bool is_by_one(const world<heap_by_one<Decomposition>>*) {
  return true;
}
constexpr bool is_by_one(const void*) { return false; }

template <class Scenario>
inline constexpr bool by_eights =
    detail::forces_in_packs<Scenario, sphere, sphere, detail::partner::moving>;
static_assert(by_eights<heap<cells>>);
static_assert(by_eights<heap<cells, momentum_balance>>);
static_assert(!by_eights<heap_by_one<cells>>);

/// Overlapping layers of spheres that fall, slide and roll. Some are fixed.
template <class World>
void fill(World& w, std::size_t materials) {
  std::vector<material_id> stuff;
  for (std::size_t k = 0; k < materials; ++k)
    stuff.push_back(w.material({.density = 1,
                                .restitution = 0.3,
                                .friction = 0.2 + 0.6 * static_cast<double>(k % 3),
                                .dynamic_friction = 0.2,
                                .youngs_modulus = 1e5 * (1 + static_cast<double>(k)),
                                .rolling_friction = k % 2 == 0 ? 0 : 0.05}));
  if constexpr (is_by_one(static_cast<World*>(nullptr)))
    for (const auto a : stuff)
      for (const auto b : stuff) w.interaction(a, b, linear_cohesion::parameters{});
  w.gravity({1, 0.5, -10});
  w.global([&](auto& s) { s.add(plane{}, stuff[0]); });
  random_stream random(11, 1);
  for (std::size_t k = 0; k < 300; ++k) {
    const auto at = [&](std::size_t n) { return -3.6 + 0.8 * static_cast<double>(n); };
    const real radius = random.uniform(0.35, 0.42);
    w.add_if_local(
        body{.shape = sphere{radius},
             .position = {at(k % 10), at(k / 10 % 10), 0.4 + 0.75 * static_cast<double>(k / 100)},
             .material = stuff[k % materials],
             .velocity = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1)),
             .angular_velocity = random.uniform(vec3(-5, -5, -5), vec3(5, 5, 5)),
             .fixed = k % 29 == 0});
  }
}

struct motion {
  vec3 position, velocity, spin;
  friend bool operator==(const motion&, const motion&) = default;
};

template <class World>
void run(World& w, std::size_t materials, std::map<system_id, motion>& all) {
  static std::mutex one_at_a_time;
  fill(w, materials);
  for (int k = 0; k < 300; ++k) w.step(1e-3);
  const std::lock_guard lock(one_at_a_time);
  w.for_each_local([&](const auto& b) {
    all[b.id()] = {b.position(), b.velocity(), b.angular_velocity()};
  });
}
template <class Scenario>
std::map<system_id, motion> moved(int ranks, std::size_t materials) {
  std::map<system_id, motion> all;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link);
    w.decompose({.lower = {-4, -4, -8}, .upper = {4, 4, 8}});
    run(w, materials, all);
  });
  return all;
}
template <class Scenario>
std::map<system_id, motion> moved_in_box(int ranks, std::size_t materials) {
  std::map<system_id, motion> all;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {{.cells = {ranks, 1, 1}, .lower = {-4, -4}, .upper = {4, 4}}},
                      reach{1});
    run(w, materials, all);
  });
  return all;
}

}  // namespace

TEST_CASE("contacts of several materials have the same bits by eights and one by one") {
  for (const std::size_t materials : {1, 3, 70}) {  // more than 64 are not kept in a table
    CAPTURE(materials);
    const auto singly = moved<heap_by_one<cells>>(1, materials);
    CHECK(singly.size() == 300);
    CHECK((moved<heap<cells, momentum_balance>>(1, materials) == singly));
    CHECK((moved<heap<cells>>(1, materials) == singly));
    if (materials == 3) CHECK((moved<heap<cells>>(4, materials) == singly));
  }
}

TEST_CASE("contacts through periodic faces have the same bits by eights and one by one") {
  using box = periodic<grid<dynamic>, along::x, along::y>;
  const auto singly = moved_in_box<heap_by_one<box>>(1, 3);
  CHECK(singly.size() == 300);
  CHECK((moved_in_box<heap<box>>(1, 3) == singly));
  CHECK((moved_in_box<heap<box>>(2, 3) == singly));
}
