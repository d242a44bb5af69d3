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
  vtk_contacts();

  template <class Scenario>
  void add_all(world<Scenario>& w) {
    const auto rank = static_cast<std::uint32_t>(w.rank());
    for_each_contact(w, [&](const loaded_contact& c) { add(c, rank); });
  }

  row_table points{"/VTKHDF"}, data{"/VTKHDF/CellData"};

 private:
  [[gnu::cold]] void add(const loaded_contact& c, std::uint32_t rank);
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/vtk_contacts_definitions.hpp"
#endif
