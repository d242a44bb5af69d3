// Cuts that move between processes: the bits of one rank.
// ranks: 1 4 7
// long
#define DOCTEST_CONFIG_IMPLEMENT
#include "../world/balanced_heap.hpp"

#include <array>
#include <talus/mpi.hpp>
#include <talus/parallel/serial.hpp>
#include <vector>

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  if (talus::detail::find_launcher().rank != 0) context.setOption("minimal", true);
  return context.run();
}

TEST_CASE("processes between which cuts move end with the bits of one rank alone") {
  const std::array plans{corner_plan{.name = "by count", .steps = 110, .every = 5, .busy = true},
                         corner_plan{.name = "by time, large bodies",
                                     .steps = 110,
                                     .every = 3,
                                     .by = balance_by::time,
                                     .busy = true,
                                     .large = true}};
  std::vector<corner_end> of_processes;
  int rank = 0, ranks = 1;
  mpi::launch({}, [&](mpi::link& link) {
    rank = link.rank(), ranks = link.size();
    for (const corner_plan& plan : plans)
      of_processes.push_back(run_corner<corner<mpi>>(link, plan));
  });
  if (rank != 0) return;
  serial::link alone;
  for (std::size_t k = 0; k < plans.size(); ++k) {
    CAPTURE(std::string(plans[k].name));
    CHECK(of_processes[k].digest == run_corner<corner<serial>>(alone, plans[k]).digest);
    if (ranks > 1) CHECK(of_processes[k].shares.moved > 10);
  }
}
