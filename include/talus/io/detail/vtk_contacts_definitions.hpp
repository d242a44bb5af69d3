#pragma once
// The definitions of vtk_contacts.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/vtk_contacts.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE vtk_contacts::vtk_contacts() {
  points.column("Points", number_type::f64, 3);
  data.column("id_a", number_type::u64)
      .column("id_b", number_type::u64)
      .column("rank", number_type::u32)
      .column("normal_force", number_type::f64)
      .column("tangential_force", number_type::f64)
      .column("force", number_type::f64, 3)
      .column("normal", number_type::f64, 3)
      .column("point", number_type::f64, 3);
}

TALUS_HDF5_INLINE void vtk_contacts::add(const loaded_contact& c, std::uint32_t rank) {
  const row_table::key key{value_of(c.a), value_of(c.b), c.feature};
  for (const vec3& end : {c.moves_a ? c.centre_a : c.point, c.moves_b ? c.centre_b : c.point}) {
    points.begin_row(key);
    points.put(end);
  }
  data.begin_row(key);
  data.put(value_of(c.a));
  data.put(value_of(c.b));
  data.put(rank);
  data.put(double{c.normal_force()});
  data.put(double{c.tangential_force().norm()});
  data.put(c.force);
  data.put(c.normal);
  data.put(c.point);
}

}  // namespace talus::detail
