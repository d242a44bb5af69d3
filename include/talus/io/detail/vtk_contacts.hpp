#pragma once
// Contacts as rows of an output: a line for each, from centre to centre, or to the contact point
// with something immovable.
#include <cstdint>

#include "talus/io/detail/row_table.hpp"
#include "talus/world/each_contact.hpp"

namespace talus::detail {

/// The tables of points, two for each contact, and of the data of contacts.
class vtk_contacts {
 public:
  vtk_contacts() {
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

  template <class Scenario>
  void add_all(world<Scenario>& w) {
    const auto rank = static_cast<std::uint32_t>(w.rank());
    for_each_contact(w, [&](const loaded_contact& c) { add(c, rank); });
  }

  row_table points{"/VTKHDF"}, data{"/VTKHDF/CellData"};

 private:
  [[gnu::cold]] void add(const loaded_contact& c, std::uint32_t rank) {
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
};

}  // namespace talus::detail
