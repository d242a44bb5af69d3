// The compiled part that needs MPI: ranks as processes, and the transport chosen by how the program
// was launched.
#include "talus/parallel/as_launched_definitions.hpp"
#include "talus/parallel/mpi_definitions.hpp"
