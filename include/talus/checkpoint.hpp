#pragma once
// Checkpoints, for scenarios that name features<checkpoints>. Needs HDF5: link talus::hdf5.
#include "talus/io/checkpoint.hpp"
#include "talus/io/checkpoint_files.hpp"
