// Periodic space: bodies that leave on one side enter on the other, on any number of ranks.
// alone
#include <doctest/doctest.h>

#include <mutex>
#include <set>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/periodic.hpp>
#include <talus/parallel/reach.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/each_contact.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

template <class Solver = nonlinear_gauss_seidel, class... More>
using sideways = scenario<bodies<sphere, box, plane>, solver<Solver>, transport<threads>,
                          decomposition<periodic<grid<dynamic>, along::x, along::y>>, More...>;

/// A box of 8 x 6 around the origin, unbounded upwards.
template <class Decomposition>
Decomposition layout(int x, int y) {
  return {{.cells = {x, y, 1}, .lower = {-4, -3}, .upper = {4, 3}}};
}

/// Runs `main(world)` on x by y ranks.
template <class Scenario, class Main>
void on(int x, int y, Main&& main) {
  CAPTURE(x);
  CAPTURE(y);
  threads::launch({.ranks = x * y}, [&](threads::link& link) {
    world<Scenario> w(link, layout<typename Scenario::decomposition>(x, y), reach{1});
    main(w);
  });
}

const std::vector<std::pair<int, int>> shares{{1, 1}, {2, 1}, {1, 2}, {3, 1}, {2, 2}, {4, 3}};

/// Two spheres that meet at `place`, in coordinates of that place; of both, in the order of their
/// ids.
template <class Scenario>
std::vector<vec3> meeting_at(const vec3& place, int x, int y) {
  std::vector<vec3> seen(4);
  std::mutex mutex;
  on<Scenario>(x, y, [&](auto& w) {
    w.material({.restitution = 0.8, .friction = 0.3});
    const auto& box = talus::detail::state_of(w).own.box();
    for (const double side : {-1.0, 1.0})
      w.add_if_local(body{.shape = sphere{0.5},
                          .position = box.wrapped(place + vec3(side, 0.1 * side, 0)),
                          .velocity = {-2 * side, 0, 0},
                          .angular_velocity = {0, 0, 3}});
    for (int k = 0; k < 100; ++k) w.step(0.01);
    w.for_each_local([&](const auto& b) {
      const std::lock_guard lock(mutex);
      const auto n = value_of(b.id()) & 1;
      CHECK(box.contains(b.position()));
      seen[2 * n] = box.nearest(b.position(), place) - place;
      seen[2 * n + 1] = b.velocity();
    });
  });
  return seen;
}

}  // namespace

TEST_CASE("spheres that meet at a side, an edge or inside part alike, on any number of ranks") {
  for (const auto& [x, y] : shares) {
    const auto inside = meeting_at<sideways<>>({0.3, 0.2, 0}, x, y);
    CHECK(inside[1][0] < -1);  // they struck
    for (const vec3& place : {vec3(4, 0.2, 0), vec3(-4, 0, 0), vec3(3.9, 3, 0), vec3(0, -3, 0)}) {
      CAPTURE(place);
      const auto there = meeting_at<sideways<>>(place, x, y);
      for (std::size_t k = 0; k < 4; ++k) CHECK((there[k] - inside[k]).norm() < 1e-12);
    }
  }
}

namespace {

/// A gas of spheres and boxes.
template <class World>
void gas(World& w, double restitution) {
  w.material({.restitution = restitution, .friction = 0.3});
  w.seed(4);
  w.fill(simple_cubic{.spacing = 1, .origin = {-3.5, -2.5, 0.5}} &
             box_region{.lower = {-4, -3, 0}, .upper = {4, 3, 3}},
         [](const site& place, random_stream& random) -> std::variant<body<sphere>, body<box>> {
           const vec3 v = random.uniform(vec3(-3, -3, -3), vec3(3, 3, 3));
           if (place.index % 3 == 0)
             return body{.shape = box{{0.6, 0.5, 0.4}},
                         .position = place.position,
                         .velocity = v,
                         .angular_velocity = v};
           return body{.shape = sphere{random.uniform(0.25, 0.45)},
                       .position = place.position,
                       .velocity = v};
         });
}

template <class Scenario>
std::string digest_of(int x, int y, int steps) {
  std::string digest;
  on<Scenario>(x, y, [&](auto& w) {
    gas(w, 0.5);
    w.gravity({0.5, 0.3, -2});
    w.global([](auto& s) { s.add(plane{}, {}); });
    for (int k = 0; k < steps; ++k) w.step(0.01);
    (void)w.audit();
    const auto found = state_digest(w);
    if (w.rank() == 0) digest = found;
  });
  return digest;
}

}  // namespace

TEST_CASE("a gas in a periodic box has the same bits on any number of ranks") {
  std::set<std::string> digests;
  for (const auto& [x, y] : shares) digests.insert(digest_of<sideways<reproducible>>(x, y, 300));
  CHECK(digests.size() == 1);
}

TEST_CASE(
    "in a box that is periodic along all axes, momentum is conserved to round-off on any ranks") {
  using everywhere =
      scenario<bodies<sphere, box>, solver<nonlinear_gauss_seidel>, transport<threads>,
               decomposition<periodic<grid<dynamic>, along::x, along::y, along::z>>>;
  for (const int ranks : {1, 2, 4, 8, 12}) {
    CAPTURE(ranks);
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<everywhere> w(link, {{.lower = {-4, -3, 0}, .upper = {4, 3, 4}}}, reach{1});
      gas(w, 0.99);
      const auto before = measure_motion(w);
      for (int k = 0; k < 300; ++k) w.step(0.01);
      (void)w.audit();
      const auto after = measure_motion(w);
      if (w.rank() != 0) return;
      CHECK((after.momentum - before.momentum).norm() < 1e-12 * after.mass);
      CHECK(after.kinetic_energy < before.kinetic_energy);
      CHECK(after.kinetic_energy > 0.2 * before.kinetic_energy);
    });
  }
}
