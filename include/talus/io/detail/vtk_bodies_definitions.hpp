#pragma once
// The definitions of vtk_bodies.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/vtk_bodies.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE std::uint8_t vtk_shapes::number(std::string_view name) const {
  std::uint8_t n = 0;
  while (n < names_.size() && names_[n] != name) ++n;
  return n;
}
TALUS_HDF5_INLINE std::string vtk_shapes::others() const {
  std::string all;
  for (std::size_t k = 6; k < names_.size(); ++k) all += std::string(names_[k]) + '\n';
  return all;
}
TALUS_HDF5_INLINE void vtk_shapes::add_name(std::string_view name) {
  if (number(name) == names_.size()) names_.push_back(name);
}

}  // namespace talus::detail
