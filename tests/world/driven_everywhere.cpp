// Driven bodies on any ranks and over a restart, with sleeping, and of all shapes.
// long
// timeout: 900
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/observe/motion.hpp>
#include <talus/shape/convex_polyhedron.hpp>
#include <talus/shape/union_of.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>

#include "driven_mixer.hpp"

using namespace driven_mixer;

TEST_CASE("the same bits on any ranks, and over a restart") {
  using scene = mixer<features<driven, checkpoints>, solver<reproducible>>;
  const std::string file = "/tmp/talus_driven_" + std::to_string(getpid()) + ".h5";
  std::string digest;
  for (const int ranks : {1, 4, 2})
    on<scene>(ranks, [&](auto& w) {
      const parts p = set_up_mixer(w);
      w.hold_force(p.side, {.force = 30, .max_speed = 0.2});
      w.simulate({.steps = 60, .dt = 0.005});
      if (ranks == 1) write_checkpoint(w, file);
      if (ranks == 2) read_checkpoint(w, file);
      w.simulate({.steps = 60, .dt = 0.005});
      const std::string mine = digest_with_walls(w, p);
      if (ranks == 1) digest = mine;
      if (w.rank() == 0) CHECK(mine == digest);
    });
  unlink(file.c_str());
}

TEST_CASE("a checkpoint is gone on with by the motion of its run, and by no other") {
  using scene = mixer<features<driven, checkpoints>, solver<reproducible>>;
  const std::string file = "/tmp/talus_motion_" + std::to_string(getpid()) + ".h5";
  bool written = false;
  for (const real speed : {3., 3., 5.}) {
    on<scene>(2, [&](auto& w) {
      handle<plane> floor;
      w.global([&](auto& s) { floor = s.add(plane{}, w.material({})); });
      w.drive(floor, turning{.axis = {0, 1, 0}, .speed = speed});
      w.add_if_local(body{.shape = box{{1, 1, 1}}, .position = {0, 1.1, 0.5}});
      if (!written) {
        w.simulate({.steps = 60, .dt = 0.005});
        write_checkpoint(w, file);
      } else {
        read_checkpoint(w, file);
        if (speed == 3)
          w.simulate({.steps = 9, .dt = 0.005});
        else
          CHECK_THROWS_WITH_AS(w.step(0.005),
                               doctest::Contains("its motion starts at another place"),
                               std::runtime_error);
      }
    });
    written = true;
  }
  unlink(file.c_str());
}

TEST_CASE("what a wall moves into wakes, on any ranks, and what it does not move into sleeps") {
  using scene = mixer<features<driven, sleeping>>;
  for (const int ranks : {1, 4})
    on<scene>(ranks, [&](auto& w) {
      w.gravity({0, 0, -10});
      const auto stuff = w.material({.density = 2, .friction = 0.5});
      handle<plane> wall;
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
      for (int k = 0; k < 560; ++k) w.step(0.005);
      CHECK(asleep() == 0);
      for (int k = 0; k < 700; ++k) w.step(0.005);
      double least = 9;
      w.for_each_local([&](const auto& b) { least = std::min(least, b.position()[0]); });
      w.link().reduce(reduction::min, std::span(&least, 1));
      CHECK(least ==
            doctest::Approx(-2 + 0.5 + 0.4).epsilon(0.02));  // they slide on by v^2 / (2 mu g)
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
    const auto correction_impulse = w.add(sphere{0.3}, stuff, {9, 0.4, 0});
    for (int k = 0; k < 150; ++k) w.step(0.01);
    CHECK(w[struck].velocity()[0] == doctest::Approx(-2).epsilon(0.1));
    CHECK(w[correction_impulse].velocity()[0] == doctest::Approx(-1).epsilon(1e-6));
  });
}
