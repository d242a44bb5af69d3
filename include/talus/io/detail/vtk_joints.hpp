#pragma once
// Joints as rows of an output: a line for each, from centre to centre by its points on both bodies.
#include <cstdint>

#include "talus/io/detail/row_table.hpp"
#include "talus/world/each_joint.hpp"

namespace talus::detail {

/// The tables of points, four for each joint, and of the data of joints.
class vtk_joints {
 public:
  static constexpr std::size_t points_of_each = 4;

  vtk_joints();

  template <class Scenario>
  void add_all(world<Scenario>& w) {
    const auto rank = static_cast<std::uint32_t>(w.rank());
    for_each_joint(w, [&](const joint_in_world& x) { add(x, rank); });
  }

  row_table points{"/VTKHDF"}, data{"/VTKHDF/CellData"};

 private:
  [[gnu::cold]] void add(const joint_in_world& x, std::uint32_t rank);
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/vtk_joints_definitions.hpp"
#endif
