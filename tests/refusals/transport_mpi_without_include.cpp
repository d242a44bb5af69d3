// expects: transport<mpi> needs MPI: write #include <talus/mpi.hpp>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<transport<threads>>;
#else
using scene = scenario<transport<mpi>>;
#endif

const scene checked;

int main() {}
