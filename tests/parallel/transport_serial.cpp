#include <doctest/doctest.h>

#include <cstdlib>

#include "talus/parallel/serial.hpp"
#include "transport_laws.hpp"

#ifdef MPI_VERSION
#error "the serial transport includes MPI"
#endif

using namespace talus;

static_assert(concepts::transport<serial> && serial::link::alone);

TEST_CASE("serial obeys the laws of transports") { transport_laws::obeys_all<serial>(1); }

TEST_CASE("serial collapses any decomposition, but refuses ranks the user asks for") {
  int calls = 0;
  serial::launch({.ranks = 0, .default_ranks = 8}, [&](auto& l) { calls += l.size(); });
  CHECK(calls == 1);
  CHECK_THROWS_WITH_AS(serial::launch({.ranks = 4}, [](auto&) {}), doctest::Contains("4 ranks"),
                       std::invalid_argument);
}

TEST_CASE("serial rethrows what main throws") {
  CHECK_THROWS_WITH_AS(serial::launch({}, [](auto&) { throw std::out_of_range("mine"); }), "mine",
                       std::out_of_range);
}

TEST_CASE("serial refuses to be several processes of one job") {
  setenv("OMPI_COMM_WORLD_SIZE", "4", 1);
  setenv("OMPI_COMM_WORLD_RANK", "0", 1);
  CHECK_THROWS_WITH_AS(serial::launch({}, [](auto&) {}),
                       doctest::Contains("mpirun started 4 processes"), std::runtime_error);
  setenv("OMPI_COMM_WORLD_RANK", "3", 1);  // one process is enough for the message
  CHECK_THROWS_AS(serial::launch({}, [](auto&) {}), aborted);
  setenv("OMPI_COMM_WORLD_SIZE", "1", 1);
  setenv("OMPI_COMM_WORLD_RANK", "0", 1);
  CHECK_NOTHROW(serial::launch({}, [](auto&) {}));
  unsetenv("OMPI_COMM_WORLD_SIZE");
  unsetenv("OMPI_COMM_WORLD_RANK");
}
