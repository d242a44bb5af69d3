// Driven bodies on any ranks, with all solvers and both kinds of contacts, with sleeping, and over
// a restart. long timeout: 900
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/force.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/observe/motion.hpp>
#include <talus/observe/penetration.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/response/accelerated_jacobi.hpp>
#include <talus/response/coloured_gauss_seidel.hpp>
#include <talus/response/small_steps.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/scene/region.hpp>
#include <talus/shape/box.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

template <class... Policies>
using mixer = scenario<bodies<sphere, box, plane>, decomposition<grid<dynamic, dynamic>>,
                       transport<threads>, Policies...>;
using watched = features<driven, energy_ledger, momentum_balance>;

/// Calls program(world) on each of `ranks` ranks (1, 2 or 4) that share out the square.
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
/// A pit whose floor is shaken and one of whose sides comes and goes, with a paddle in it.
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
  w.fill(simple_cubic{.spacing = 0.9, .origin = {0.1, 0.1, 0.1}} &
             box_region{{-3.4, -3.4, 1.5}, {3.4, 3.4, 4}},
         [&](const site& place, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.3, 0.42)},
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

template <class Scenario>
void mix(double most_overlap) {
  for (const int ranks : {1, 4})
    on<Scenario>(ranks, [&](auto& w) {
      const parts p = set_up_mixer(w);
      real side = -4;
      double overlap = 0;
      for (int k = 0; k < 400; ++k) {
        side += 0.005 * 0.3 * std::sin(0.005 * (k + 0.5));
        w.step(0.005);
        if (k % 20 == 0) overlap = std::max(overlap, measure_penetration(w).max);
      }
      CHECK(std::abs(w[p.side].shape().offset - side) < 1e-12);
      CHECK(overlap < most_overlap);
      CHECK(measure_energy(w).worst < 1e-11);
      CHECK(measure_energy(w).total.work > 1);
      CHECK(measure_momentum(w).error() < 1e-11);
      w.for_each_local([&](const auto& b) { CHECK(b.position()[2] > -0.2); });
      (void)w.audit();
    });
}

}  // namespace

TEST_CASE("all solvers stir and shake, and the books close") {
  mix<mixer<watched>>(0.3);
  mix<mixer<watched, solver<small_steps>>>(0.3);
  mix<mixer<watched, solver<accelerated_jacobi>>>(0.4);
  mix<mixer<watched, precision<mixed_precision>>>(0.3);
}

TEST_CASE("so do soft contacts") {
  mix<mixer<watched, soft_contact<linear_spring_dashpot, coulomb_friction>>>(0.3);
  mix<mixer<watched, soft_contact<hertz_mindlin, coulomb_friction>, integrator<velocity_verlet>>>(
      0.5);
}

TEST_CASE("a soft ball takes on the speed of a belt, and bounces off a wall that comes") {
  using scene = mixer<soft_contact<linear_spring_dashpot, coulomb_friction>, watched>;
  on<scene>(1, [&](auto& w) {
    const auto stuff =
        w.material({.density = 2, .restitution = 0.5, .friction = 0.5, .stiffness = 1e5});
    handle<plane> wall;
    w.global([&](auto& s) { wall = s.add(plane{.normal = {1, 0, 0}, .offset = -3}, stuff); });
    w.drive(wall, gliding{{2, 0, 0}});
    const auto h = w.add(sphere{0.5}, stuff, {0, 0, 0});
    for (int k = 0; k < 4000; ++k) w.step(0.0005);
    CHECK(w[h].velocity()[0] == doctest::Approx(3).epsilon(0.02));
  });
}

TEST_CASE("the same bits on any ranks, and over a restart") {
  using scene = mixer<features<driven, checkpoints>, solver<reproducible>>;
  const std::string file = "/tmp/talus_driven_" + std::to_string(getpid()) + ".h5";
  std::string digest;
  for (const int ranks : {1, 4, 2})
    on<scene>(ranks, [&](auto& w) {
      const parts p = set_up_mixer(w);
      w.hold_force(p.side, {.force = 30, .max_speed = 0.2});
      w.simulate({.steps = 100, .dt = 0.005});
      if (ranks == 1) write_checkpoint(w, file);
      if (ranks == 2) read_checkpoint(w, file);
      w.simulate({.steps = 100, .dt = 0.005});
      const std::string mine = digest_with_walls(w, p);
      if (ranks == 1) digest = mine;
      if (w.rank() == 0) CHECK(mine == digest);
    });
  unlink(file.c_str());
}

TEST_CASE("what a wall moves into wakes, on any ranks, and what it does not move into sleeps") {
  using scene = mixer<features<driven, sleeping>>;
  for (const int ranks : {1, 4})
    on<scene>(ranks, [&](auto& w) {
      w.gravity({0, 0, -10});
      const auto stuff = w.material({.density = 2, .friction = 0.5});
      handle<plane> wall;
      handle<box> belt_of_box;
      w.global([&](auto& s) {
        s.add(plane{}, stuff);
        wall = s.add(plane{.normal = {1, 0, 0}, .offset = -8}, stuff);
      });
      for (int k = 0; k < 7; ++k)
        w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {k - 3.0, 1.1, 0.5}});
      const auto asleep = [&] { return measure_motion(w).asleep; };
      for (int k = 0; k < 300; ++k) w.step(0.005);
      CHECK(asleep() == 7);
      const real t0 = w.time();
      w.drive(wall, [=](real t) {
        return rigid_displacement{.shift = {std::min(2 * (t - t0), real(6)), 0, 0}};
      });
      for (int k = 0; k < 400; ++k) w.step(0.005);
      CHECK(asleep() == 7 - 7);
      double least = 9;
      w.for_each_local([&](const auto& b) { least = std::min(least, b.position()[0]); });
      w.link().reduce(reduction::min, std::span(&least, 1));
      CHECK(least == doctest::Approx(-2 + 0.5).epsilon(0.02));
      for (int k = 0; k < 700; ++k) w.step(0.005);
      CHECK(asleep() == 7);
    });
}

TEST_CASE("polyhedra and unions are driven as others are") {
  using rod = union_of<sphere, box>;
  using scene = scenario<bodies<sphere, convex_polyhedron, rod, plane>, transport<threads>,
                         decomposition<grid<dynamic, dynamic>>, features<driven>>;
  on<scene>(1, [&](auto& w) {
    const auto stuff = w.material({.density = 1});
    const rod dumbbell({{box{{4, 0.2, 0.2}}, {}}, {sphere{0.5}, {{2, 0, 0}}}});
    const convex_polyhedron wedge({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}});
    handle<rod> bat;
    handle<convex_polyhedron> plough;
    const pose at = placed(dumbbell), there = placed(wedge, {{10, 0, -0.5}, {1, 0, 0, 0}});
    w.global([&](auto& s) {
      bat = s.add(dumbbell, stuff, at.position, at.orientation);
      plough = s.add(wedge, stuff, there.position, there.orientation);
    });
    w.drive(bat, turning{.axis = {0, 0, 1}, .speed = 1});
    w.drive(plough, gliding{{-1, 0, 0}});
    const auto struck = w.add(sphere{0.3}, stuff, {0, 2, 0});
    const auto pushed = w.add(sphere{0.3}, stuff, {9, 0.4, 0});
    for (int k = 0; k < 150; ++k) w.step(0.01);
    CHECK(w[struck].velocity()[0] == doctest::Approx(-2).epsilon(0.1));
    CHECK(w[pushed].velocity()[0] == doctest::Approx(-1).epsilon(1e-6));
  });
}
