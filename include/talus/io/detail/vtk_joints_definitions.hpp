#pragma once
// The definitions of vtk_joints.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/vtk_joints.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE vtk_joints::vtk_joints() {
  points.column("Points", number_type::f64, 3);
  data.column("id_a", number_type::u64)
      .column("id_b", number_type::u64)
      .column("kind", number_type::u32)
      .column("rank", number_type::u32)
      .column("force", number_type::f64, 3)
      .column("torque", number_type::f64, 3)
      .column("angle", number_type::f64)
      .column("travel", number_type::f64)
      .column("gap", number_type::f64);
}

TALUS_HDF5_INLINE void vtk_joints::add(const joint_in_world& x, std::uint32_t rank) {
  const row_table::key key{value_of(x.a), value_of(x.b), x.number};
  for (const vec3& at : {x.centre_a, x.point_a, x.point_b, x.centre_b}) {
    points.begin_row(key);
    points.put(at);
  }
  data.begin_row(key);
  data.put(value_of(x.a));
  data.put(value_of(x.b));
  data.put(x.kind);
  data.put(rank);
  data.put(x.force);
  data.put(x.torque);
  data.put(double{x.angle});
  data.put(double{x.travel});
  data.put(double{(x.point_a - x.point_b).norm()});
}

}  // namespace talus::detail
