// Ranks also run where MPI has no one-sided communication, as between machines on Ethernet with
// Debian's Open MPI.
// ranks: 2
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <cstdlib>

#include "../parallel/transport_laws.hpp"
#include "talus/parallel/mpi.hpp"

using namespace talus;
using namespace talus::transport_laws;

int main(int argc, char** argv) {
  // Open MPI reads it when it starts; other MPIs do not.
  setenv("OMPI_MCA_osc", "^sm,rdma,pt2pt,ucx,portals4,monitoring", 1);
  const boost::mpi::environment environment(argc, argv, false);
  doctest::Context context(argc, argv);
  if (boost::mpi::communicator{}.rank() != 0) context.setOption("minimal", true);
  return context.run();
}

TEST_CASE("mpi obeys the laws of transports without windows") {
  obeys_all<mpi>(boost::mpi::communicator{}.size());
}
