// Contacts solved in float: ranks as processes end with the bits of ranks as threads.
// ranks: 2 4
// long
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdlib>
#include <talus/mpi.hpp>
#include <talus/observe/digest.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>

using namespace talus;

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  if (detail::find_launcher().rank != 0) context.setOption("minimal", true);
  return context.run();
}

namespace {

template <class Transport>
using heap = scenario<bodies<sphere, plane>, precision<mixed_precision>,
                      decomposition<grid<dynamic, dynamic>>, transport<Transport>>;

template <class Transport>
std::string digest_of(typename Transport::link& link) {
  constexpr real side = 4;
  world<heap<Transport>> w(link, {.lower = {0, 0}, .upper = {side, side}});
  w.material({.restitution = 0.3, .friction = 0.4});
  w.gravity({0, 0, -10});
  w.global([&](auto& scope) {
    scope.add(plane{}, {});
    for (const vec3& n : {vec3(1, 0, 0), vec3(0, 1, 0)}) {
      scope.add(plane{.normal = n}, {});
      scope.add(plane{.normal = -n, .offset = -side}, {});
    }
  });
  w.fill(simple_cubic{.spacing = 0.8, .origin = {0.4, 0.4, 0.4}} &
             box_region{{0, 0, 0}, {side, side, 3.2}},
         [](const site& at, random_stream& random) {
           return body{.shape = sphere{random.uniform(0.3, 0.4)},
                       .position = at.position,
                       .velocity = random.uniform(vec3(-2, -2, -2), vec3(2, 2, 2))};
         });
  for (int k = 0; k < 200; ++k) w.step(1.0 / 240);
  return state_digest(w);
}

}  // namespace

TEST_CASE("processes and threads end with the same bits, contacts solved in float") {
  int ranks = 0;
  bool speaks = false;
  std::string of_processes, of_threads;
  mpi::launch({}, [&](mpi::link& link) {
    ranks = link.size();
    speaks = link.rank() == 0;
    of_processes = digest_of<mpi>(link);
  });
  if (!speaks) return;
  // Threads refuse to run in one of several processes; with this the process counts as the only
  // one.
  for (const char* name :
       {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "MV2_COMM_WORLD_RANK", "SLURM_PROCID", "PMIX_RANK"})
    unsetenv(name);
  threads::launch({.ranks = ranks}, [&](threads::link& link) {
    const std::string digest = digest_of<threads>(link);
    if (link.rank() == 0) of_threads = digest;
  });
  MESSAGE(ranks, " ranks: ", of_processes);
  CHECK(of_processes == of_threads);
}
