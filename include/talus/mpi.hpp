#pragma once
// All of talus, with the transports that use MPI: transport<mpi> and transport<as_launched>.
#if !__has_include(<mpi.h>) || !__has_include(<boost/mpi/communicator.hpp>)
#error \
    "<talus/mpi.hpp> needs MPI and Boost.MPI: in CMake write find_package(talus COMPONENTS mpi) and link talus::mpi"
#else
#include "talus/parallel/as_launched.hpp"
#include "talus/parallel/mpi.hpp"
#include "talus/talus.hpp"
#endif
