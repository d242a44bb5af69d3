// Tutorial: a user-defined communicator. Talus starts MPI, not this program.
// ranks: 1 4
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <talus/mpi.hpp>

using namespace talus;

using blocks = scenario<bodies<sphere>, decomposition<grid<dynamic>>, transport<mpi>>;

int main(int argc, char** argv) {
  doctest::Context context(argc, argv);
  if (detail::find_launcher().rank != 0) context.setOption("minimal", true);
  return context.run();
}

TEST_CASE("a world runs on a communicator of one's own, with a tag of one's own") {
  CHECK(!boost::mpi::environment::initialized());
  const boost::mpi::environment environment;  // only because MPI is needed before the run
  const int size = boost::mpi::communicator{}.size();

  int dims[] = {0, 1, 1}, periods[] = {false, false, false};
  MPI_Dims_create(size, 3, dims);
  MPI_Comm cartesian;
  MPI_Cart_create(MPI_COMM_WORLD, 3, dims, periods, true, &cartesian);

  const boost::mpi::communicator ranks(cartesian, boost::mpi::comm_take_ownership);
  const int tag = 42;
  mpi::launch({{}, ranks, tag}, [&](mpi::link& link) {
    world<blocks> world(link, {.cells = {dims[0], dims[1], dims[2]}, .lower = {0}, .upper = {8}});
    // ...
    CHECK(world.ranks() == size);
    world.check_connections();
    const auto iron = world.material(materials::iron);
    for (int k = 0; k < 8; ++k)
      world.add_if_local(body{.shape = sphere{0.4}, .position = {k + 0.5, 0, 0}, .material = iron});
    for (int step = 0; step < 10; ++step) world.step(0.01);
    CHECK(world.local_bodies() == 8u / static_cast<unsigned>(size));
  });
}
