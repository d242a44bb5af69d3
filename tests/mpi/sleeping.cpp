// Islands that sleep and wake across processes.
// ranks: 1 2 4
// long
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cmath>
#include <talus/mpi.hpp>
#include <talus/observe/motion.hpp>

using namespace talus;

using row =
    scenario<bodies<sphere>, features<sleeping>, decomposition<grid<dynamic>>, transport<mpi>>;

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  if (detail::find_launcher().rank != 0) context.setOption("minimal", true);
  return context.run();
}

TEST_CASE("a row of bodies through all processes falls asleep, and wakes before it is struck") {
  mpi::launch({}, [](mpi::link& link) {
    world<row> w(link, {.cells = {link.size()}, .lower = {0}, .upper = {16}});
    w.material({.restitution = 0});
    w.sleeping({.speed = 0.05, .time = 0.1});
    for (int k = 0; k < 16; ++k)
      w.add_if_local(body{.shape = sphere{0.5}, .position = {k + 0.5, 0, 0}});
    for (int k = 0; k < 40; ++k) w.step(0.005);
    const motion before = measure_motion(w);
    CHECK(before.asleep == 16);
    const std::uint64_t collectives = w.step_messages().collectives;
    w.add_if_local(body{.shape = sphere{0.5}, .position = {-1, 0, 0}, .velocity = {4, 0, 0}});
    double last = 0;
    for (int k = 0; k < 60; ++k) {
      w.step(0.005);
      CHECK(std::abs(measure_motion(w).momentum[0] - 4 * before.mass / 16) < 1e-12);
    }
    CHECK(w.step_messages().collectives == collectives);
    CHECK(measure_motion(w).asleep == 0);
    w.for_each_local([&](const auto& b) {
      if (b.position()[0] > 15) last = b.velocity()[0];
    });
    w.link().reduce(reduction::max, std::span(&last, 1));
    CHECK(last > 0.1);
  });
}
