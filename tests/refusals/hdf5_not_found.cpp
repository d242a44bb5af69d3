// expects: <talus/checkpoint.hpp> needs HDF5: in CMake write find_package(talus COMPONENTS mpi
// hdf5) and link talus::hdf5
#ifdef TALUS_CONTROL
#include <talus/talus.hpp>
#else
#include <talus/checkpoint.hpp>
#endif

int main() {}
