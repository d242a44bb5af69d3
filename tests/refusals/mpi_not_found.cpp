// expects: <talus/mpi.hpp> needs MPI and Boost.MPI: in CMake write find_package(talus COMPONENTS
// mpi) and link talus::mpi
#ifdef TALUS_CONTROL
#include <talus/talus.hpp>
#else
#include <talus/mpi.hpp>
#endif

int main() {}
