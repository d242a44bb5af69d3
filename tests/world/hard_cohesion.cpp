// Hard contacts that stick: the bound of the pull in closed form, the same for all solvers, and to
// the bit on any number of ranks.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <talus/features/energy_ledger/energy_ledger.hpp>
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

using namespace talus;

namespace {

using sticky = hard_contact<coulomb_friction, normal_cohesion>;
template <class Solver, class Law = sticky>
using scene = scenario<bodies<sphere, box, plane>, Law, solver<Solver>, transport<threads>>;

using dimer = scenario<bodies<sphere>, sticky, features<forces, energy_ledger>, transport<threads>>;

constexpr real g = 10, dt = 0.005;

/// Calls f(world) with a world on one rank.
template <class Scenario, class F>
void in_world(F&& f) {
  threads::launch({.ranks = 1}, [&](threads::link& link) {
    world<Scenario> w(link);
    f(w);
  });
}

/// The way down of a body after 100 steps below a plane that it touches.
template <class Solver, class Shape>
real fall_below(const Shape& shape, real half_height, real weight, real cohesion) {
  real way = 0;
  in_world<scene<Solver>>([&](auto& w) {
    w.gravity({0, 0, -g});
    w.solver().iterations = 30;
    const auto wet = w.material({.density = 1, .friction = 0.5});
    w.material_pair(wet, wet, {.friction = 0.5, .cohesion = cohesion * weight});
    w.global([&](auto& scope) { scope.add(plane{.normal = {0, 0, -1}}, wet); });
    w.add(body{.shape = shape, .position = {0, 0, -half_height}, .material = wet});
    for (int k = 0; k < 100; ++k) w.step(dt);
    w.for_each_local([&](const auto& b) { way = -half_height - b.position()[2]; });
  });
  return way;
}

template <class Solver>
void hang_and_fall() {
  const real ball = 4.0 / 3 * std::acos(real(-1)) * 0.125;
  CHECK(fall_below<Solver>(sphere{0.5}, 0.5, ball * g, 1 / 0.99) < 1e-3);
  CHECK(fall_below<Solver>(sphere{0.5}, 0.5, ball * g, 1 / 1.01) > 5e-3);
  CHECK(fall_below<Solver>(box{{1, 0.8, 0.6}}, 0.3, 0.48 * g, 1 / 0.99) < 1e-3);
  CHECK(fall_below<Solver>(box{{1, 0.8, 0.6}}, 0.3, 0.48 * g, 1 / 1.01) > 5e-3);
}

/// The speed of a box after 100 steps on a plane in a field of this slope.
real speed_on(real slope, real mu, real cohesion) {
  real speed = 0;
  in_world<scene<nonlinear_gauss_seidel>>([&](auto& w) {
    const real angle = std::atan(slope), weight = 0.48 * g;
    w.gravity({g * std::sin(angle), 0, -g * std::cos(angle)});
    w.solver().iterations = 100;
    const auto wet = w.material({.density = 1, .friction = mu});
    w.material_pair(wet, wet, {.friction = mu, .cohesion = cohesion * weight});
    w.global([&](auto& scope) { scope.add(plane{}, wet); });
    w.add(body{.shape = box{{1, 0.8, 0.6}}, .position = {0, 0, 0.3}, .material = wet});
    for (int k = 0; k < 100; ++k) w.step(dt);
    w.for_each_local([&](const auto& b) { speed = b.velocity().norm(); });
  });
  return speed;
}

template <class Law>
std::string digest_of_pile(int ranks, real cohesion) {
  using pile = scenario<bodies<sphere, plane>, Law, solver<reproducible>,
                        decomposition<grid<dynamic, dynamic>>, transport<threads>>;
  std::string digest;
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    world<pile> w(link, grid<dynamic, dynamic>{.lower = {-2, -2}, .upper = {2, 2}});
    w.gravity({0, 0, -g});
    const auto wet = w.material({.density = 1, .friction = 0.5});
    w.material_pair(wet, wet, {.friction = 0.5, .cohesion = cohesion});
    w.global([&](auto& scope) { scope.add(plane{}, wet); });
    w.fill(simple_cubic{.spacing = 0.5, .origin = {0.25, 0.25, 0.25}} &
               box_region{{-1, -1, 0}, {1, 1, 2}},
           [&](const site& place, random_stream& random) {
             return body{.shape = sphere{random.uniform(0.2, 0.25)},
                         .position = place.position,
                         .material = wet};
           });
    for (int k = 0; k < 60; ++k) w.step(dt);
    const std::string mine = state_digest(w);
    if (link.rank() == 0) digest = mine;
  });
  return digest;
}

}  // namespace

TEST_CASE("spheres and boxes hang below a plane up to the cohesion, and fall beyond it") {
  hang_and_fall<nonlinear_gauss_seidel>();
  hang_and_fall<substepping>();
  hang_and_fall<accelerated_jacobi>();
  hang_and_fall<reproducible>();
}

TEST_CASE("a sticky box slides on a slope beyond mu + mu F_c / (m g cos)") {
  const real mu = 0.3, cohesion = 0.5;
  // tan = mu (1 + F_c / (m g cos)), solved for the angle by iteration.
  real slope = mu;
  for (int k = 0; k < 100; ++k) slope = mu * (1 + cohesion * std::sqrt(1 + slope * slope));
  CHECK(speed_on(0.99 * slope, mu, cohesion) < 1e-3);
  CHECK(speed_on(1.02 * slope, mu, cohesion) > 0.01);
  CHECK(speed_on(1.02 * mu, mu, 0) > 0.01);
}

TEST_CASE("a sticky dimer in free flight holds together up to the cohesion") {
  for (const real pull : {0.99, 1.01}) {
    CAPTURE(pull);
    in_world<dimer>([&](auto& w) {
      const auto wet = w.material({.density = 1});
      w.material_pair(wet, wet, {.friction = 0.5, .cohesion = 1});
      for (const real side : {-0.5, 0.5})
        w.add(body{.shape = sphere{0.5},
                   .position = {side, 0, 0},
                   .material = wet,
                   .velocity = {1, 2, 3}});
      const vec3 middle{0.5, 1, 1.5};  // after 100 steps
      for (int k = 0; k < 100; ++k) {
        vec3 centre{0, 0, 0};
        w.for_each_local([&](const auto& b) { centre += 0.5 * b.position(); });
        w.for_each_local([&](auto& b) {
          b.add_force({b.position()[0] > centre[0] ? pull : -pull, 0, 0});
        });
        w.step(dt);
      }
      vec3 sum{0, 0, 0}, centre{0, 0, 0};
      real low = 1e9, high = -1e9;
      w.for_each_local([&](const auto& b) {
        sum += b.velocity(), centre += 0.5 * b.position();
        low = std::min(low, b.position()[0]), high = std::max(high, b.position()[0]);
      });
      CHECK((sum - vec3(2, 4, 6)).norm() < 1e-12);
      CHECK((centre - middle).norm() < 1e-12);
      if (pull < 1)
        CHECK(std::abs(high - low - 1) < 1e-9);
      else
        CHECK(high - low > 1.001);
    });
  }
}

TEST_CASE("no cohesion leaves the bits of the law without it, and ranks agree to the bit") {
  CHECK(digest_of_pile<sticky>(1, 0) == digest_of_pile<hard_contact<coulomb_friction>>(1, 0));
  const std::string one = digest_of_pile<sticky>(1, 0.05);
  CHECK(one != digest_of_pile<sticky>(1, 0));
  CHECK(one == digest_of_pile<sticky>(2, 0.05));
  CHECK(one == digest_of_pile<sticky>(4, 0.05));
}

TEST_CASE("a collapsing column stays the higher the more its spheres stick") {
  // Bond numbers: cohesion over the weight of a sphere, with steps of an hundredth of a second.
  const auto height = [](real bond) {
    real mean = 0;
    in_world<scenario<bodies<sphere, plane>, sticky, transport<threads>>>([&](auto& w) {
      w.gravity({0, 0, -g});
      const real radius = 0.1, weight = 4.0 / 3 * std::acos(real(-1)) * 1e-3 * g;
      const auto wet = w.material({.density = 1, .friction = 0.3});
      w.material_pair(wet, wet, {.friction = 0.3, .cohesion = bond * weight});
      w.global([&](auto& scope) { scope.add(plane{}, wet); });
      w.seed(3);
      w.fill(simple_cubic{.spacing = 0.2, .origin = {0.1, 0.1, 0.1}} &
                 box_region{{-0.4, -0.4, 0}, {0.4, 0.4, 1.6}},
             [&](const site& place, random_stream& random) {
               return body{.shape = sphere{radius * random.uniform(0.97, 1.0)},
                           .position = place.position,
                           .material = wet};
             });
      for (int k = 0; k < 200; ++k) w.step(0.01);
      int count = 0;
      w.for_each_local([&](const auto& b) { mean += b.position()[2], ++count; });
      mean /= count;
    });
    return mean;
  };
  const real dry = height(0), damp = height(3), wet = height(30);
  CAPTURE(dry);
  CAPTURE(damp);
  CAPTURE(wet);
  CHECK(damp > 1.1 * dry);
  CHECK(wet > 1.1 * damp);
}
