// Loads on which sweeps stall, with the reproducible solver: exact, and the same bits wherever the
// domains end.
#include <doctest/doctest.h>

#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/islands.hpp>
#include <talus/observe/monitors.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <vector>

#include "ranks.hpp"

using namespace talus;

namespace {

template <class... Features>
using alike = scenario<bodies<sphere, box, plane>, solver<reproducible>, transport<threads>,
                       decomposition<hard::cuts>, features<Features...>>;

constexpr real g = 9.81, dt = 1. / 240;
/// One domain, and borders across and along the stack, through its contacts or beside them.
const std::vector<std::array<int, 3>> ways_to_cut{{1, 1, 1}, {2, 1, 1}, {1, 1, 2},
                                                  {1, 1, 4}, {2, 2, 1}, {2, 1, 2}};

struct result {
  std::string digest;
  real overlap = 0, speed = 0, worst = 0;
  std::uint64_t islands = 0;
};

/// `edge`: the domains together reach from -edge to edge, and from 0 to `top`.
template <class Scenario, class SetUp>
result run(const std::array<int, 3>& cells, real edge, real top, int steps, SetUp&& set_up) {
  result r;
  threads::launch({.ranks = cells[0] * cells[1] * cells[2]}, [&](threads::link& link) {
    world<Scenario> w(link);
    w.decompose(hard::cuts{.cells = cells, .lower = {-edge, -edge, 0}, .upper = {edge, edge, top}},
                {.distance = 4 * edge});
    w.gravity({0, 0, -g});
    set_up(w);
    for (int k = 0; k < steps; ++k) w.step(dt);
    const auto overlap = measure_penetration(w);
    const auto motion = measure_motion(w);
    const auto islands = measure_islands(w);
    const auto digest = state_digest(w);
    real worst = 0;
    if constexpr (talus::detail::monitored<Scenario, energy_ledger>)
      worst = measure_energy(w).worst;
    if (link.rank() != 0) return;
    r = {digest, overlap.max, motion.max_speed, worst, islands.solved};
  });
  return r;
}

template <class World>
void stack(World& w, int boxes, real density) {
  const auto light = w.material({.density = 1, .friction = 0.5});
  const auto heavy = w.material({.density = density, .friction = 0.5});
  w.global([&](auto& scope) { scope.add(plane{}, light); });
  for (int k = 0; k < boxes; ++k)
    w.add_if_local(body{.shape = box{{1, 1, 1}},
                        .position = {0.01, 0.013, k + 0.5},
                        .material = k + 1 == boxes ? heavy : light});
}

}  // namespace

TEST_CASE("stacks under a load of up to 1e4 times their density rest, wherever domains end") {
  for (const auto& [boxes, density] :
       std::vector<std::pair<int, real>>{{10, 1e3}, {10, 1e4}, {30, 1e3}}) {
    std::string first;
    for (const auto& cells : ways_to_cut) {
      INFO(boxes, " boxes, density ", density, ", domains ", cells[0], cells[1], cells[2]);
      const result r =
          run<alike<>>(cells, 2, boxes + 1.13, 240, [&](auto& w) { stack(w, boxes, density); });
      CHECK(r.overlap < 1e-9);
      CHECK(r.speed < 1e-7);
      CHECK(r.islands > 0);
      if (first.empty()) first = r.digest;
      CHECK(r.digest == first);
    }
  }
}

TEST_CASE("plates of 1e4 times the density rest on spheres, wherever domains end") {
  for (const int side : {4, 10}) {
    std::string first;
    for (const auto& cells : ways_to_cut) {
      INFO(side, " spheres a side, domains ", cells[0], cells[1], cells[2]);
      const result r = run<alike<>>(cells, 0.5 * side + 1, 2.1, 120, [&](auto& w) {
        const auto light = w.material({.density = 1, .friction = 0.5});
        const auto heavy = w.material({.density = 1e4, .friction = 0.5});
        w.global([&](auto& scope) { scope.add(plane{}, light); });
        for (int i = 0; i < side * side; ++i)
          w.add_if_local(
              body{.shape = sphere{0.5},
                   .position = {i % side - 0.5 * (side - 1), i / side - 0.5 * (side - 1), 0.5},
                   .material = light});
        w.add_if_local(body{
            .shape = box{vec3(side, side, 1)}, .position = {0.01, 0.01, 1.5}, .material = heavy});
      });
      CHECK(r.overlap < 1e-8);
      CHECK(r.speed < 1e-7);
      if (first.empty()) first = r.digest;
      CHECK(r.digest == first);
    }
  }
}

TEST_CASE("bodies of densities from 1 to 1e4 that fall on each other have the same bits") {
  const auto heap = [](auto& w) {
    w.global([&](auto& scope) {
      const auto floor = w.material({.friction = 0.5});
      scope.add(plane{}, floor);
      for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0)})
        scope.add(plane{.normal = n, .offset = -1.9}, floor);
    });
    random_stream random(7);
    for (int k = 0; k < 45; ++k) {
      const auto stuff = w.material({.density = std::exp(random.uniform(0, std::log(1e4))),
                                     .restitution = 0.3,
                                     .friction = 0.5});
      const vec3 at = vec3(k % 3 - 1, k / 3 % 3 - 1, 1.1 * (k / 9) + 0.6) +
                      random.uniform(vec3(-.05, -.05, 0), vec3(.05, .05, 0));
      const quat turn = random.rotation();
      if (k % 3 == 0)
        w.add_if_local(body{.shape = sphere{0.45}, .position = at, .material = stuff});
      else
        w.add_if_local(body{
            .shape = box{{0.6, 0.5, 0.4}}, .position = at, .material = stuff, .orientation = turn});
    }
  };
  const auto check = [&]<class Scenario>(Scenario) {
    std::string first;
    for (const auto& cells : ways_to_cut) {
      INFO("domains ", cells[0], cells[1], cells[2]);
      const result r = run<Scenario>(cells, 2, 3, 600, heap);
      // The worst closure is relative to the energy of one rank, which may own light bodies alone.
      CHECK(r.worst < (cells[0] * cells[1] * cells[2] == 1 ? 1e-9 : 1e-5));
      if (first.empty()) first = r.digest;
      CHECK(r.digest == first);
    }
  };
  check(alike<energy_ledger>{});
  check(alike<sleeping>{});
}
