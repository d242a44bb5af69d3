#pragma once
// Checkpoints, for scenarios that name features<checkpoints>. Needs HDF5: link talus::hdf5.
#if !__has_include(<hdf5.h>)
#error \
    "<talus/checkpoint.hpp> needs HDF5: in CMake write find_package(talus COMPONENTS mpi hdf5) and link talus::hdf5"
#else
#include "talus/io/checkpoint.hpp"
#include "talus/io/checkpoint_files.hpp"
#endif
