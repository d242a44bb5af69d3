// A cable of joints over processes has the bits of one rank, and keeps its momentum.
// ranks: 1 2 4
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cmath>
#include <optional>
#include <string>
#include <talus/constraint/ball_joint.hpp>
#include <talus/mpi.hpp>
#include <talus/observe/digest.hpp>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/slabs.hpp>

using namespace talus;

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  if (detail::find_launcher().rank != 0) context.setOption("minimal", true);
  return context.run();
}

namespace {

template <class Transport>
using cable = scenario<bodies<sphere>, joints<ball_joint>, solver<reproducible>,
                       decomposition<slabs<dynamic>>, transport<Transport>>;

struct outcome {
  std::string digest;
  vec3 before{0, 0, 0}, after{0, 0, 0};
};
template <class Transport>
outcome run_cable(typename Transport::link& link) {
  world<cable<Transport>> w(link, slabs<dynamic>{.lower = -4, .upper = 4});
  const auto stuff = w.material({});
  std::optional<handle<sphere>> last;
  for (int k = 0; k < 14; ++k) {
    const vec3 at(-3.2 + 0.5 * k, 0.3 * std::sin(k), 0);
    const auto next = w.add_if_local(body{.shape = sphere{0.2},
                                          .position = at,
                                          .material = stuff,
                                          .velocity = {0.5 * std::cos(k), std::sin(3.0 * k), 1}});
    if (k > 0) (void)w.join(last, next, ball_joint{.at = at - vec3(0.25, 0, 0)});
    last = next;
  }
  w.synchronize();
  outcome result;
  result.before = measure_motion(w).momentum;
  for (int k = 0; k < 400; ++k) w.step(2e-3);
  result.after = measure_motion(w).momentum;
  result.digest = state_digest(w);
  return result;
}

}  // namespace

TEST_CASE("a cable over processes has the bits of one rank") {
  mpi::launch({}, [](mpi::link& link) {
    const outcome many = run_cable<mpi>(link);
    if (link.rank() != 0) return;
    CHECK((many.after - many.before).norm() < 1e-13 * (1 + many.before.norm()));
    serial::link alone;
    CHECK(run_cable<serial>(alone).digest == many.digest);
  });
}
