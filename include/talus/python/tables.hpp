#pragma once
// Tables of bodies and contacts in Python, and the loads of many bodies.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "talus/observe/loads.hpp"
#include "talus/observe/tables.hpp"
#include "talus/python/module.hpp"

namespace talus::detail {

/// The columns of a table as a dictionary of arrays of one dimension, of which pandas makes a
/// frame.
[[nodiscard]] inline pybind11::dict arrays_of(const data_table& table) {
  namespace py = pybind11;
  py::dict all;
  for (const data_table::column& c : table.columns())
    std::visit(
        [&](const auto& values) {
          using value = typename std::remove_cvref_t<decltype(values)>::value_type;
          if constexpr (std::is_same_v<value, std::string_view>) {
            std::map<std::string_view, py::str> words;
            py::list rows(values.size());
            for (std::size_t i = 0; i < values.size(); ++i)
              rows[i] =
                  words.try_emplace(values[i], values[i].data(), values[i].size()).first->second;
            all[c.name.c_str()] = py::module_::import("numpy").attr("array")(rows, "str");
          } else {
            all[c.name.c_str()] =
                py::array_t<value>(static_cast<py::ssize_t>(values.size()), values.data());
          }
        },
        c.values);
  return all;
}

/// Tables of all bodies and contacts, and the loads of some bodies.
template <class Session, class Class>
void bind_tables(Class& world_class) {
  namespace py = pybind11;
  using driven = driven_world<Session>;
  using world_type = typename Session::world_type;
  if constexpr (Session::world_type::scenario_type::template has_feature<events>)
    world_class.def(
        "event_table",
        [](driven& d) {
          return arrays_of(d.session->read([](world_type& w) { return event_table(w); }));
        },
        "The events of the last step, by the ids of their bodies, likewise.");
  world_class
      .def(
          "body_table",
          [](driven& d) {
            return arrays_of(d.session->read([](world_type& w) { return body_table(w); }));
          },
          "All bodies, global ones too, by their ids, as a dictionary of arrays of one dimension: "
          "pandas.DataFrame(world.body_table()).")
      .def(
          "contact_table",
          [](driven& d) {
            return arrays_of(d.session->read([](world_type& w) { return contact_table(w); }));
          },
          "The contacts that carry a force, by the ids of their bodies, likewise.")
      .def(
          "write_body_table",
          [](driven& d, const std::string& file) {
            const std::string& name = file_of_python(file, "write_body_table");
            d.session->read([](world_type& w) { return body_table(w); }).write_csv(name);
          },
          py::arg("file"), "Writes the table of bodies as comma-separated values.")
      .def(
          "write_contact_table",
          [](driven& d, const std::string& file) {
            const std::string& name = file_of_python(file, "write_contact_table");
            d.session->read([](world_type& w) { return contact_table(w); }).write_csv(name);
          },
          py::arg("file"), "Writes the table of contacts likewise.")
      .def(
          "contact_forces",
          [](driven& d, const std::vector<std::uint64_t>& ids) {
            std::vector<system_id> bodies;
            for (const std::uint64_t id : ids) bodies.push_back(system_id{id});
            const auto loads =
                d.session->read([&](world_type& w) { return talus::contact_forces(w, bodies); });
            const auto n = static_cast<py::ssize_t>(loads.size());
            py::array_t<real> force({n, py::ssize_t{3}}), torque({n, py::ssize_t{3}});
            for (py::ssize_t i = 0; i < n; ++i)
              for (int k = 0; k < 3; ++k) {
                const contact_load& load = loads[static_cast<std::size_t>(i)];
                force.mutable_at(i, k) = load.force[k];
                torque.mutable_at(i, k) = load.torque[k];
              }
            return py::make_tuple(force, torque);
          },
          py::arg("ids"),
          "Force of all contacts on each of these bodies, and torque about its position: two "
          "arrays, with a row for each id.");
}

}  // namespace talus::detail
