#pragma once
// All of talus, with the transports that use MPI: transport<mpi> and transport<as_launched>.
#include "talus/parallel/as_launched.hpp"
#include "talus/parallel/mpi.hpp"
#include "talus/talus.hpp"
