#pragma once
// What Python reads of a world as numpy arrays.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/python/lent_columns.hpp"
#include "talus/state/state.hpp"
#include "talus/world/each_contact.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// A column of the bodies of one shape that this rank owns, without a copy. Throws attribute_error
/// if they have none of that name.
template <class Store>
[[nodiscard]] pybind11::array column_of(lent_columns& lent, Store& b, const std::string& name) {
  using shape = typename Store::shape_type;
  const std::size_t n = b.locals;
  const auto vectors = [&](auto& column) {
    return lent.template lend<real>(column, n, 3, n > 0 ? &column[0][0] : nullptr);
  };
  if (name == "positions") return vectors(b.position);
  if (name == "velocities") return vectors(b.velocity);
  if (name == "angular_velocities") return vectors(b.angular_velocity);
  if (name == "ids") {
    static_assert(sizeof(system_id) == sizeof(std::uint64_t));
    return lent.template lend<std::uint64_t>(
        b.id, n, 0, n > 0 ? reinterpret_cast<const std::uint64_t*>(&b.id[0]) : nullptr);
  }
  if constexpr (Store::oriented)
    if (name == "orientations") {
      static_assert(sizeof(quat) == 4 * sizeof(real));  // x, y, z, w
      auto& column = b.orientation_of;
      return lent.template lend<real>(column, n, 4,
                                      n > 0 ? reinterpret_cast<const real*>(&column[0]) : nullptr);
    }
  if constexpr (requires(const shape& s) { requires std::same_as<decltype(s.radius), real>; })
    if (name == "radii")
      return lent.template lend<real>(b.shape, n, 0, n > 0 ? &b.shape[0].radius : nullptr);
  throw pybind11::attribute_error(
      compose("a {} has no {}{}", shape::name, name,
              name == "orientations" ? ": name features<orientation> in the scenario" : ""));
}

/// The names of the shapes of which bodies can move, in the order of the scenario.
template <class Scenario>
[[nodiscard]] std::vector<std::string> movable_shapes(world<Scenario>& w) {
  std::vector<std::string> names;
  state_of(w).each_finite_shape(
      [&](auto& b) { names.emplace_back(std::remove_cvref_t<decltype(b)>::shape_type::name); });
  return names;
}

/// The column of the bodies of the shape of that name.
template <class Scenario>
[[nodiscard]] pybind11::array column_of_shape(lent_columns& lent, world<Scenario>& w,
                                              const std::string& shape, const std::string& name) {
  pybind11::array found;
  state_of(w).each_finite_shape([&](auto& b) {
    if (std::remove_cvref_t<decltype(b)>::shape_type::name == shape)
      found = column_of(lent, b.movable, name);
  });
  return found;
}

/// The contacts that carry a force, as columns.
struct contact_columns {
  std::vector<std::uint64_t> a, b;
  std::vector<std::array<real, 3>> point, normal, force;
  std::vector<real> gap;

  template <class Scenario>
  [[nodiscard]] static contact_columns of(world<Scenario>& w) {
    contact_columns c;
    const auto three = [](const vec3& v) { return std::array<real, 3>{v[0], v[1], v[2]}; };
    for_each_contact(w, [&](const loaded_contact& x) {
      c.a.push_back(value_of(x.a)), c.b.push_back(value_of(x.b));
      c.point.push_back(three(x.point)), c.normal.push_back(three(x.normal));
      c.force.push_back(three(x.force)), c.gap.push_back(x.gap);
    });
    return c;
  }
  /// Returns a dictionary of arrays, with the names of the output files.
  [[nodiscard]] pybind11::dict arrays() const {
    namespace py = pybind11;
    const auto n = static_cast<py::ssize_t>(a.size());
    const auto threes = [&](const std::vector<std::array<real, 3>>& v) {
      return py::array_t<real>({n, py::ssize_t{3}}, n > 0 ? v[0].data() : nullptr);
    };
    py::dict all;
    all["id_a"] = py::array_t<std::uint64_t>(n, a.data());
    all["id_b"] = py::array_t<std::uint64_t>(n, b.data());
    all["point"] = threes(point);
    all["normal"] = threes(normal);
    all["force"] = threes(force);
    all["gap"] = py::array_t<real>(n, gap.data());
    return all;
  }
};

}  // namespace talus::detail
