#pragma once
// Scenes of the reproducible solver on one domain, and on several that end elsewhere.
#include <array>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/islands.hpp>
#include <talus/observe/monitors.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <vector>

#include "ranks.hpp"

namespace talus::hard {

template <class... Features>
using alike = scenario<bodies<sphere, box, plane>, solver<reproducible>, transport<threads>,
                       decomposition<cuts>, features<Features...>>;

inline constexpr real g = 9.81, dt = 1. / 240;
/// One domain, and borders across and along the stack, through its contacts or beside them.
inline const std::vector<std::array<int, 3>> ways_to_cut{{1, 1, 1}, {2, 1, 1}, {1, 1, 2},
                                                         {1, 1, 4}, {2, 2, 1}, {2, 1, 2}};

struct cut_result {
  std::string digest;
  real overlap = 0, speed = 0, worst = 0;
  std::uint64_t islands = 0;
};

/// `edge`: the domains together reach from -edge to edge, and from 0 to `top`.
template <class Scenario, class SetUp>
cut_result run_cut(const std::array<int, 3>& cells, real edge, real top, int steps,
                   SetUp&& set_up) {
  cut_result r;
  threads::launch({.ranks = cells[0] * cells[1] * cells[2]}, [&](threads::link& link) {
    world<Scenario> w(link);
    w.decompose(cuts{.cells = cells, .lower = {-edge, -edge, 0}, .upper = {edge, edge, top}},
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

/// Bodies of densities from 1 to 1e4 that fall on each other between walls.
template <class World>
void mixed_heap(World& w) {
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
}

}  // namespace talus::hard
