// Damping with the midpoint: of second order, with closed books, the same on any ranks and after
// restarts.
#include <doctest/doctest.h>

#include <unistd.h>

#include <cmath>
#include <string>
#include <talus/checkpoint.hpp>
#include <talus/constraint/hinge.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/energy.hpp>
#include <talus/observe/momentum.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>
#include <talus/world/world.hpp>

using namespace talus;

namespace {

constexpr real kept = 0.3;  // of the velocity in a second

template <class... Features>
using alone = scenario<bodies<sphere, box, plane>, transport<serial>, integrator<moreau_midpoint>,
                       joints<hinge>, features<damping, Features...>>;

/// How far a thrown box is from its place in closed form after a second.
real error_of_flight(int steps) {
  serial::link link;
  world<alone<>> w(link);
  w.material({});
  w.gravity({0, 0, -9.81});
  w.damping(kept);
  const vec3 v0(3, 1, 5), g(0, 0, -9.81);
  const auto h = w.add(body<box>{.shape = box{{1, 1, 1}}, .velocity = v0});
  for (int k = 0; k < steps; ++k) w.step(1.0 / steps);
  const real c = -std::log(kept), rest = 1 - kept;
  const vec3 place = (rest / c) * v0 + (1 / c - rest / (c * c)) * g;
  return (w.find(h)->position() - place).norm();
}
/// The place of the lower one of two jointed rods after a second.
vec3 end_of_pendulum(int steps) {
  serial::link link;
  world<alone<>> w(link);
  w.material({});
  w.gravity({0, 0, -9.81});
  w.damping(kept);
  const box rod{{0.1, 0.1, 1}};
  const auto upper = w.add(
      body<box>{.shape = rod, .position = {0.5, 0, 0}, .orientation = rotation({0, 1, 0}, pi / 2)});
  const auto lower = w.add(
      body<box>{.shape = rod, .position = {1.5, 0, 0}, .orientation = rotation({0, 1, 0}, pi / 2)});
  w.join(world_frame, upper, hinge{.axis = {0, 1, 0}});
  w.join(upper, lower, hinge{.at = {1, 0, 0}, .axis = {0, 1, 0}});
  for (int k = 0; k < steps; ++k) w.step(1.0 / steps);
  return w.find(lower)->position();
}

template <class World>
void add_walls(World& w) {
  w.gravity({1, 0, -9.81});
  w.damping(kept);
  const auto m = w.material({.restitution = 0.4, .friction = 0.4});
  w.global([&](auto& scope) {
    scope.add(plane{{0, 0, 1}, 0}, m);
    for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0)})
      scope.add(plane{n, 0}, m), scope.add(plane{-n, -4}, m);
  });
}
template <class World>
void fill_box(World& w) {
  add_walls(w);
  random_stream random(3);
  for (int n = 0; n < 64; ++n) {
    const vec3 at(0.5 + n % 4, 0.5 + n / 4 % 4, 0.6 + n / 16);
    const vec3 v = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2));
    if (n % 2 == 0)
      w.add_if_local(
          body<sphere>{.shape = sphere{0.4}, .position = at, .velocity = v, .angular_velocity = v});
    else
      w.add_if_local(body<box>{
          .shape = box{{0.5, 0.6, 0.7}}, .position = at, .velocity = v, .angular_velocity = v});
  }
  w.synchronize();
}

}  // namespace

TEST_CASE("a damped flight is of second order with the midpoint") {
  const real coarse = error_of_flight(20), fine = error_of_flight(40);
  CHECK(coarse < 5e-3);
  CHECK(std::log2(coarse / fine) == doctest::Approx(2).epsilon(0.02));
}

TEST_CASE("a damped double pendulum is of second order with the midpoint") {
  const vec3 a = end_of_pendulum(200), b = end_of_pendulum(400), c = end_of_pendulum(800);
  CHECK((b - c).norm() < 1e-3);
  CHECK(std::log2((a - b).norm() / (b - c).norm()) == doctest::Approx(2).epsilon(0.1));
}

TEST_CASE("books of energy and momentum close with damping and the midpoint") {
  serial::link link;
  world<alone<energy_ledger, momentum_balance>> w(link);
  fill_box(w);
  real worst = 0, momentum = 0;
  for (int k = 0; k < 600; ++k) {
    w.step(1.0 / 240);
    worst = std::max(worst, measure_energy(w).error());
    momentum = std::max(momentum, measure_momentum(w).error());
  }
  const energy_balance e = measure_energy(w);
  CHECK(worst < 1e-12);
  CHECK(momentum < 1e-11);
  CHECK(e.total.damping > 0.1 * e.scale);
  CHECK(e.kinetic + e.potential == doctest::Approx(e.initial + e.total.net()).epsilon(1e-11));
}

TEST_CASE("damped bodies have the same bits with the midpoint on any ranks and after restarts") {
  using scene = scenario<bodies<sphere, box, plane>, solver<reproducible>,
                         integrator<moreau_midpoint>, transport<threads>,
                         decomposition<grid<dynamic, dynamic>>, features<damping, checkpoints>>;
  const auto digest_of = [](int ranks, const std::string& read, const std::string& written) {
    std::string digest;
    threads::launch({.ranks = ranks}, [&](threads::link& link) {
      world<scene> w(link, {.cells = {ranks == 4 ? 2 : ranks, ranks == 4 ? 2 : 1},
                            .lower = {0, 0},
                            .upper = {4, 4}});
      if (read.empty())
        fill_box(w);
      else
        add_walls(w), read_checkpoint(w, read);
      while (w.steps() < 300) {
        if (w.steps() == 150 && !written.empty()) write_checkpoint(w, written);
        w.step(1.0 / 240);
      }
      const std::string found = state_digest(w);
      if (link.rank() == 0) digest = found;
    });
    return digest;
  };
  const std::string file = "/tmp/talus_damping_" + std::to_string(getpid()) + ".h5";
  const std::string digest = digest_of(2, "", file);
  for (const int ranks : {1, 4}) {
    CAPTURE(ranks);
    CHECK(digest_of(ranks, "", "") == digest);
    CHECK(digest_of(ranks, file, "") == digest);
  }
  unlink(file.c_str());
}
