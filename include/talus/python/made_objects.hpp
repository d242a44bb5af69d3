#pragma once
// Objects of Python whose __init__ was not called, as those of World.__new__(World).
#include <pybind11/pybind11.h>

#include <string>

namespace talus::detail {

/// Reads an object of Python as a Type. Throws type_error for an object that holds none, of which
/// pybind11 would read memory without a value.
template <class Type>
struct caster_of_made_objects : pybind11::detail::type_caster_base<Type> {
  bool load(pybind11::handle source, bool convert) {
    namespace py = pybind11;
    if (py::isinstance<Type>(source)) {
      auto* const object = reinterpret_cast<py::detail::instance*>(source.ptr());
      if (!object->get_value_and_holder().holder_constructed()) {
        const auto name = py::type::of(source).attr("__name__").template cast<std::string>();
        throw py::type_error("this " + name + " was made without its __init__, and has no value");
      }
    }
    return py::detail::type_caster_base<Type>::load(source, convert);
  }
};

}  // namespace talus::detail
