#pragma once
// A pit with spheres whose floor is shaken, with one oscillating side, and in which a paddle
// rotates, for the tests of driven bodies.
#include <cmath>
#include <string>
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>

namespace driven_mixer {

using namespace talus;

template <class... Policies>
using mixer = scenario<bodies<sphere, box, plane>, decomposition<grid<dynamic, dynamic>>,
                       transport<threads>, Policies...>;
using watched = features<driven, energy_ledger, momentum_balance>;

/// Calls program(world) on each of `ranks` ranks (1, 2 or 4) that share the square.
template <class Scenario, class Program>
void on(int ranks, Program&& program) {
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, {.lower = {-4, -4}, .upper = {4, 4}}, reach{4});
    program(w);
  });
}

struct parts {
  handle<plane> floor, side;
  handle<box> paddle;
};
/// A pit whose floor is shaken and one of whose sides oscillates, with a paddle in it.
template <class World>
parts set_up_mixer(World& w) {
  w.gravity({0, 0, -10});
  const auto stuff = w.material(
      {.density = 2, .restitution = 0.2, .friction = 0.5, .stiffness = 2e4, .youngs_modulus = 1e6});
  parts p;
  w.global([&](auto& s) {
    p.floor = s.add(plane{}, stuff);
    p.side = s.add(plane{.normal = {1, 0, 0}, .offset = -4}, stuff);
    s.add(plane{.normal = {-1, 0, 0}, .offset = -4}, stuff);
    s.add(plane{.normal = {0, 1, 0}, .offset = -4}, stuff);
    s.add(plane{.normal = {0, -1, 0}, .offset = -4}, stuff);
    p.paddle = s.add(box{{5, 0.5, 1}}, stuff, {0, 0, 0.6});
  });
  w.drive(p.floor, oscillation{.amplitude = {0.2, 0, 0.05}, .frequency = 2});
  w.drive(p.side, [](real t) { return rigid_velocity{.velocity = {0.3 * std::sin(t), 0, 0}}; });
  w.drive(p.paddle, turning{.axis = {0, 0, 1}, .speed = 1.5});
  w.fill(simple_cubic{.spacing = 1.1, .origin = {0.1, 0.1, 0.1}} &
             box_region{{-3.4, -3.4, 1.5}, {3.4, 3.4, 3.4}},
         [&](const site& place, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.35, 0.5)},
                       .position = place.position,
                       .material = stuff};
         });
  return p;
}
template <class World>
std::string digest_with_walls(World& w, const parts& p) {
  return state_digest(w) + detail::text(w[p.side].shape().offset, 17) +
         detail::text(w[p.paddle].position()[0], 17);
}

}  // namespace driven_mixer
