// expects: transport<as_launched> needs MPI: write #include <talus/mpi.hpp>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<transport<threads>>;
#else
using scene = scenario<transport<as_launched>>;
#endif

const scene checked;

int main() {}
