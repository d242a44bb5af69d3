// The compiled part that needs MPI: the transport that fits how the program was started.
#include "talus/parallel/as_launched_definitions.hpp"
