#pragma once
// The joints of a world for Python.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "talus/constraint/joint_axis.hpp"
#include "talus/core/error.hpp"
#include "talus/python/made_objects.hpp"
#include "talus/state/state.hpp"
#include "talus/world/joint_handle.hpp"
#include "talus/world/state_of.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// A motor from the keyword arguments of Python. Throws type_error for one that it does not have.
template <class Motor>
[[nodiscard]] Motor motor_from(const pybind11::kwargs& given) {
  Motor m;
  real* largest = nullptr;
  const char* largest_name = nullptr;
  if constexpr (std::is_same_v<Motor, torque_motor>)
    largest = &m.largest_torque, largest_name = "largest_torque";
  else
    largest = &m.largest_force, largest_name = "largest_force";
  const std::pair<const char*, real*> fields[] = {{"velocity", &m.velocity},
                                                  {largest_name, largest},
                                                  {"position", &m.position},
                                                  {"stiffness", &m.stiffness},
                                                  {"damping", &m.damping}};
  for (const auto& [key, value] : given) {
    const auto name = key.template cast<std::string>();
    const auto* const found = std::find_if(std::begin(fields), std::end(fields),
                                           [&](const auto& field) { return name == field.first; });
    if (found == std::end(fields))
      throw pybind11::type_error(
          compose("set_motor has no argument {}: it takes velocity, {}, position, stiffness and "
                  "damping",
                  name, largest_name));
    *found->second = value.template cast<real>();
  }
  return m;
}

/// A joint of any kind.
struct any_joint {
  std::string kind;
  std::uint64_t number = 0;  ///< of the call of join()
  std::uint64_t a = 0, b = 0;
  std::function<std::array<real, 3>()> force, torque;
  std::function<real()> angle, travel;  ///< empty where the kind has none
  std::function<void(const pybind11::kwargs&)> set_motor;
  std::function<void()> release;
};

}  // namespace talus::detail

/// Functions of Python refuse such an object without a value.
template <>
class pybind11::detail::type_caster<talus::detail::any_joint>
    : public talus::detail::caster_of_made_objects<talus::detail::any_joint> {};

namespace talus::detail {

template <class Session, class Kind>
[[nodiscard]] any_joint joint_for_python(const std::shared_ptr<Session>& s, const joint_key& key) {
  using world_type = typename Session::world_type;
  using handle = joint_handle<typename world_type::scenario_type, Kind>;
  const auto read = [s, key](auto f) {
    return [s, key, f] {
      return s->read([&](world_type& w) {
        const handle joint(w, key);
        return f(joint);
      });
    };
  };
  const auto three = [](const vec3& v) { return std::array<real, 3>{v[0], v[1], v[2]}; };
  any_joint j;
  j.kind = Kind::name, j.number = key.number;
  j.a = value_of(key.a), j.b = value_of(key.b);
  j.force = read([three](const handle& h) { return three(h.force()); });
  j.torque = read([three](const handle& h) { return three(h.torque()); });
  if constexpr (requires(const handle& h) { h.angle(); })
    j.angle = read([](const handle& h) { return h.angle(); });
  if constexpr (requires(const handle& h) { h.travel(); })
    j.travel = read([](const handle& h) { return h.travel(); });
  constexpr bool turns = requires(typename Kind::anchors & x, torque_motor m) {
    Kind::drive(x, m);
  };
  constexpr bool pushes = requires(typename Kind::anchors & x, force_motor m) {
    Kind::drive(x, m);
  };
  if constexpr (turns || pushes)
    j.set_motor = [s, key](const pybind11::kwargs& given) {
      const auto set = [&](const auto& motor) {
        s->change([&](world_type& w) { handle(w, key).set_motor(motor); });
      };
      if constexpr (turns && pushes) {
        if (given.contains("largest_force"))
          set(motor_from<force_motor>(given));
        else
          set(motor_from<torque_motor>(given));
      } else if constexpr (turns) {
        set(motor_from<torque_motor>(given));
      } else {
        set(motor_from<force_motor>(given));
      }
    };
  j.release = [s, key] { s->change([&](world_type& w) { handle(w, key).release(); }); };
  return j;
}

/// The joints of the world, in the order in which they were joined.
template <class Session>
[[nodiscard]] std::vector<any_joint> joints_of(const std::shared_ptr<Session>& s) {
  std::vector<any_joint> all;
  auto& state = state_of(s->open());
  if constexpr (requires { state.joints.size(); }) {
    state.joints.each_kind([&](const auto& of_kind) {
      using kind = typename std::remove_cvref_t<decltype(of_kind)>::kind;
      for (const auto& r : of_kind.records)
        all.push_back(joint_for_python<Session, kind>(s, r.key));
    });
    std::sort(all.begin(), all.end(),
              [](const any_joint& x, const any_joint& y) { return x.number < y.number; });
  }
  return all;
}

/// Makes the class Joint of a module.
inline void bind_joints(pybind11::module_& module) {
  namespace py = pybind11;
  const auto need = [](const auto& f, const any_joint& j, const char* what) {
    if (!f) throw py::attribute_error(compose("a {} has no {}", j.kind, what));
  };
  py::class_<any_joint>(module, "Joint", py::module_local(),
                        "A joint between two bodies, in the order of world.joints.")
      .def_readonly("kind", &any_joint::kind, "hinge, slider, ball joint, ...")
      .def_readonly("id_a", &any_joint::a, "id of the first body")
      .def_readonly("id_b", &any_joint::b, "id of the second body")
      .def_property_readonly(
          "angle", [need](const any_joint& j) { return need(j.angle, j, "angle"), j.angle(); },
          "Angle of the second body relative to the first, in radians.")
      .def_property_readonly(
          "travel", [need](const any_joint& j) { return need(j.travel, j, "travel"), j.travel(); },
          "Travel of the second body along the axis.")
      .def_property_readonly(
          "force", [](const any_joint& j) { return py::array_t<real>(3, j.force().data()); },
          "Mean force on the first body in the last step.")
      .def_property_readonly(
          "torque", [](const any_joint& j) { return py::array_t<real>(3, j.torque().data()); },
          "Mean torque on the first body in the last step, about the point of the joint.")
      .def(
          "set_motor",
          [need](const any_joint& j, const py::kwargs& given) {
            need(j.set_motor, j, "motor");
            j.set_motor(given);
          },
          "Changes the motor from the next step on: velocity, largest_torque (of a slider "
          "largest_force), position, stiffness, damping; what is left out is 0.")
      .def(
          "release", [](const any_joint& j) { j.release(); }, "Removes the joint.");
}

}  // namespace talus::detail
