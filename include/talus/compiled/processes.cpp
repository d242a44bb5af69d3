// The compiled part that needs MPI: ranks as processes, and the transport that fits how the program
// was started.
#include "talus/parallel/as_launched_definitions.hpp"
#include "talus/parallel/mpi_definitions.hpp"
