#pragma once
// A pile of spheres and boxes with all entries of the energy ledger, for the tests of monitors.
#include <talus/observe/digest.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/shape/box.hpp>
#include <talus/world/world.hpp>
#include <variant>

namespace monitored {

using namespace talus;

template <class... Features>
using scene = scenario<bodies<sphere, box, plane>, transport<threads>,
                       decomposition<grid<dynamic, dynamic>>, features<Features...>>;
using plain = scene<forces, damping>;
using watched = scene<forces, damping, energy_ledger, momentum_balance, penetration_monitor>;

using rolling_springs = soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>;
using hertz_springs = soft_contact<hertz_mindlin, coulomb_friction>;
template <class Law, class Integrator, class... Features>
using soft_scene = scenario<bodies<sphere, plane>, Law, integrator<Integrator>, transport<threads>,
                            decomposition<grid<dynamic, dynamic>>, features<damping, Features...>>;

constexpr double round_off = 1e-13;
constexpr real g = 9.81, dt = 1.0 / 240;

inline grid<dynamic, dynamic> cells() { return {.lower = {-3, -3}, .upper = {3, 3}}; }

/// Spheres in a pit; if the scenario has them, boxes too, of which one is a belt.
template <class World>
void set_up_pile(World& w) {
  using scenario_type = typename World::scenario_type;
  constexpr bool boxes = scenario_type::template has_shape<box>;
  w.gravity({0, 0, -g});
  if constexpr (scenario_type::template has_feature<damping>) w.damping(0.9);
  const auto stuff = w.material({.density = 1.5,
                                 .restitution = 0.5,
                                 .friction = 0.4,
                                 .stiffness = 5e3,
                                 .youngs_modulus = 2e5,
                                 .rolling_friction = 0.05});
  w.seed(11);
  w.global([&](auto& scope) {
    scope.add(plane{}, stuff);
    for (const real side : {-1.0, 1.0}) {
      scope.add(plane{.normal = {side, 0, 0}, .offset = -3}, stuff);
      scope.add(plane{.normal = {0, side, 0}, .offset = -3}, stuff);
    }
  });
  w.fill(simple_cubic{.spacing = 1.1} & box_region{{-2.5, -2.5, 0.9}, {2.5, 2.5, 5}},
         [&](const site& place, random_stream& random) {
           const vec3 v = random.uniform(vec3(-1, -1, -1), vec3(1, 1, 1));
           const body<sphere> ball{.shape = sphere{random.uniform(0.3, 0.5)},
                                   .position = place.position,
                                   .material = stuff,
                                   .velocity = v,
                                   .angular_velocity = 3 * v};
           if constexpr (boxes) {
             using either = std::variant<body<sphere>, body<box>>;
             if (random.uniform(0, 1) < 0.5) return either(ball);
             const vec3 size = random.uniform(vec3(0.4, 0.4, 0.4), vec3(0.7, 0.6, 0.6));
             return either(body<box>{.shape = box{size},
                                     .position = place.position,
                                     .material = stuff,
                                     .velocity = v,
                                     .orientation = random.rotation()});
           } else {
             return ball;
           }
         });
  if constexpr (boxes) {
    const auto belt = w.add_if_local(body{
        .shape = box{{2, 2, 0.5}}, .position = {0.1, 0.1, 0.3}, .material = stuff, .fixed = true});
    if (belt) w[*belt].set_velocity({1.5, 0, 0});
  }
}
template <class World>
void push_some(World& w) {
  w.for_each_local([](auto& b) {
    if (value_of(b.id()) % 5 == 0 && !b.is_fixed()) b.add_force({0.5, -1, 0.2});
    if (value_of(b.id()) % 7 == 0 && !b.is_fixed()) b.add_torque({0.1, 0, 0.3});
  });
}

/// The state after some steps of a pile.
template <class Scenario>
std::string digest_of_pile(int ranks) {
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<Scenario> w(link, cells());
    set_up_pile(w);
    w.synchronize();
    for (int k = 0; k < 200; ++k) {
      if constexpr (Scenario::template has_feature<forces>) push_some(w);
      w.step(dt);
    }
    const std::string here = state_digest(w);
    if (w.rank() == 0) digest = here;
  });
  return digest;
}

}  // namespace monitored
