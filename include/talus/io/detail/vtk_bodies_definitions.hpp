#pragma once
// The definitions of vtk_bodies.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/vtk_bodies.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::uint8_t vtk_shape_number(std::string_view name) {
  std::uint8_t n = 0;
  for (const std::string_view known : vtk_shape_names) {
    if (known == name) return n;
    ++n;
  }
  return n;
}

}  // namespace talus::detail
