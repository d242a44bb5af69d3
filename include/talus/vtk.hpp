#pragma once
// Output for ParaView, VTK and Python: write_vtk, vtk_series, and --output for scenarios that name
// features<vtk_output>. Needs HDF5: link talus::hdf5.
#include "talus/io/vtk.hpp"
