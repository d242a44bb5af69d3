// The promises of every solver: the same scene on as many ranks ends with the same bits, under any
// load of the machine.
// long
// timeout: 3600
#include <doctest/doctest.h>

#include <string>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/solver/accelerated_jacobi.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/solver/substepping.hpp>
#include <talus/world/world.hpp>
#include <vector>

using namespace talus;

namespace {

constexpr real side = 6;

template <class... Policies>
using scene = scenario<bodies<sphere, box, plane>, decomposition<grid<dynamic, dynamic>>,
                       transport<threads>, Policies...>;
using soft =
    scene<soft_contact<linear_spring_dashpot, coulomb_friction>, integrator<velocity_verlet>>;

/// A pile of spheres, or of boxes with friction, in a box of planes: digests during the run.
template <class Scenario>
std::vector<std::string> digests(int ranks, bool boxes) {
  std::vector<std::string> all;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = {0, 0}, .upper = {side, side}});
    w.gravity({0, 0, -10});
    w.seed(7);
    const auto stuff =
        w.material({.restitution = 0.2, .friction = 0.5, .stiffness = 2e4, .youngs_modulus = 1e6});
    w.global([&](auto& scope) {
      scope.add(plane{.normal = {0, 0, 1}}, stuff);
      scope.add(plane{.normal = {1, 0, 0}}, stuff);
      scope.add(plane{.normal = {-1, 0, 0}, .offset = -side}, stuff);
      scope.add(plane{.normal = {0, 1, 0}}, stuff);
      scope.add(plane{.normal = {0, -1, 0}, .offset = -side}, stuff);
    });
    w.fill(simple_cubic{.spacing = 1} & box_region{{0.4, 0.4, 0.6}, {side - 0.4, side - 0.4, 5}},
           [&](const site& at, random_stream& random) -> std::variant<body<sphere>, body<box>> {
             const vec3 push = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
             if (!boxes)
               return body{.shape = sphere{random.uniform(0.35, 0.45)},
                           .position = at.position,
                           .velocity = push};
             return body{.shape = box{random.uniform(vec3(0.4, 0.4, 0.4), vec3(0.6, 0.6, 0.6))},
                         .position = at.position,
                         .velocity = push,
                         .orientation = random.rotation()};
           });
    for (int part = 0; part < 3; ++part) {
      for (int k = 0; k < 1000; ++k) w.step(Scenario::contact_law::soft ? 1.0 / 4000 : 1.0 / 240);
      const auto digest = state_digest(w);
      if (link.rank() == 0) all.push_back(digest);
    }
  });
  return all;
}

}  // namespace

TEST_CASE_TEMPLATE(
    "3,000 steps of a pile of spheres and of one of boxes end with the same bits again", Scene,
    scene<>, scene<solver<accelerated_jacobi>>, scene<solver<substepping>>,
    scene<solver<reproducible>>, soft) {
  for (const bool boxes : {false, true})
    for (const int ranks : {1, 4}) {
      CAPTURE(boxes);
      CAPTURE(ranks);
      const auto once = digests<Scene>(ranks, boxes);
      CHECK(once.size() == 3);
      CHECK(once[0] != once[1]);
      CHECK(digests<Scene>(ranks, boxes) == once);
    }
}
