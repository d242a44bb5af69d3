#pragma once
// Machines of all kinds of joints on one rank, and their bricks.
#include <cmath>
#include <talus/observe/energy.hpp>
#include <talus/observe/joints.hpp>
#include <talus/observe/motion.hpp>
#include <talus/world/each_joint.hpp>
#include <talus/world/world.hpp>

#include "../scenes/machines.hpp"
#include "../scenes/machines_midpoint.hpp"

namespace machines {

using namespace talus;

constexpr real g = 9.81;

using first_order = scenes::machines;
using second_order = scenes::machines_midpoint;

/// Calls f(world, a material of density 1) on one rank.
template <class Scenario = first_order, class F>
void in_world(F&& f) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<Scenario> w(link);
    w.gravity({0, 0, -g});
    const auto stuff = w.material({.density = 1});
    f(w, stuff);
  });
}
inline const box brick{.size = {0.6, 0.4, 0.2}};
constexpr real mass = 0.6 * 0.4 * 0.2;

template <class World>
handle<box> add_brick(World& w, material_id stuff, const vec3& at) {
  return *w.add_if_local(body{.shape = brick, .position = at, .material = stuff});
}
template <class World>
real energy_of(World& w) {
  const auto e = measure_energy(w);
  return e.kinetic + e.potential;
}

}  // namespace machines
