#include <boost/mpi.hpp>

#include <talus/core/math.hpp>

int main(int argc, char** argv) {
  boost::mpi::environment environment(argc, argv);
  const boost::mpi::communicator world;
  return world.size() == 1 && talus::vec3(3, 4, 0).norm() == 5 ? 0 : 1;
}
