#pragma once
// talus::python::scenario<Scenario>(module, set_up): a compiled scenario as a Python module.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "talus/python/changes.hpp"
#include "talus/python/module.hpp"
#include "talus/python/queries.hpp"
#include "talus/python/tables.hpp"

namespace talus {

namespace detail {

/// The numbers of a world that Python reads as properties.
template <class Session, class Class>
void bind_figures(Class& world_class) {
  namespace py = pybind11;
  using driven = driven_world<Session>;
  using world_type = typename Session::world_type;
  world_class
      .def_property_readonly(
          "time", [](driven& d) { return d.session->open().time(); }, "Elapsed time.")
      .def_property_readonly(
          "steps", [](driven& d) { return d.session->open().steps(); }, "Steps made so far.")
      .def_property_readonly(
          "finished", [](driven& d) { return d.session->over(); },
          "Whether the set-up has come to its end, so that no more steps can be made.")
      .def_property(
          "gravity",
          [](driven& d) {
            const vec3& g = d.session->open().gravity();
            return py::make_tuple(g[0], g[1], g[2]);
          },
          [](driven& d, const std::array<real, 3>& g) {
            d.session->change([&](world_type& w) { w.gravity({g[0], g[1], g[2]}); });
          },
          "Acceleration of all bodies.")
      .def_property_readonly(
          "kinetic_energy",
          [](driven& d) {
            return d.session->read([](world_type& w) { return measure_motion(w).kinetic_energy; });
          },
          "Kinetic energy of all bodies, of translation and rotation.")
      .def_property_readonly(
          "digest",
          [](driven& d) { return d.session->read([](world_type& w) { return state_digest(w); }); },
          "state_digest of the present state, 16 hexadecimal digits.")
      .def_property_readonly(
          "contacts",
          [](driven& d) {
            return d.session->read([](world_type& w) { return contact_columns::of(w); }).arrays();
          },
          "The contacts that carry a force, as a dictionary of arrays: id_a, id_b, point, normal "
          "(from b towards a), force (on a), gap. Copies.")
      .def(
          "results",
          [](driven& d) {
            const std::string text = d.session->read([&](world_type& w) {
              talus::summary figures = summarize(w, 0, 0);
              figures.scenario = d.session->name();
              figures.own = d.session->own();
              return to_json(figures);
            });
            return py::module_::import("json").attr("loads")(text);
          },
          "What the program writes for --json, of the present state, as a dictionary. Its times of "
          "the whole run are 0; what the set-up returns is in it once the set-up has ended.");
}

/// Changes of the bodies of one shape.
template <class Session, class Class>
void bind_changes(Class& bodies_class) {
  namespace py = pybind11;
  using bodies = bodies_of_one_shape<Session>;
  using world_type = typename Session::world_type;
  constexpr std::array<real, 3> none{0, 0, 0};
  bodies_class
      .def(
          "add",
          [](const bodies& b, const py::args& sizes, const std::array<real, 3>& position,
             const std::array<real, 3>& velocity, const std::array<real, 3>& angular_velocity,
             const std::array<real, 4>& orientation, const std::optional<real>& mass,
             const std::optional<real>& density, std::uint16_t material) {
            const auto numbers = value_from<std::vector<real>>(sizes, sizes_are_numbers);
            const new_body how{position, velocity, angular_velocity, orientation,
                               material, mass,     density};
            return b.session->change(
                [&](world_type& w) { return add_body(w, b.shape, numbers, how); });
          },
          py::arg("position"), py::arg("velocity") = none, py::arg("angular_velocity") = none,
          // After *args, pybind11 2.10 does not convert the last argument: a density of 3 would be
          // refused, 3.0 not.
          py::arg("orientation") = std::array<real, 4>{0, 0, 0, 1}, py::arg("mass") = py::none(),
          py::arg("density") = py::none(), py::arg("material") = 0,
          "Adds a body and returns its id: add(radius, position=...), of a box add(x, y, z, "
          "position=...), of a capsule or cylinder add(radius, length, position=...). The material "
          "is its number in the order of the set-up; mass or density replaces its density.")
      .def(
          "remove",
          [](const bodies& b, std::uint64_t id) {
            b.session->change([&](world_type& w) {
              on_shape(w, b.shape, [&]<class Shape>(std::type_identity<Shape>) {
                w.destroy(handle<Shape>{system_id{id}});
              });
            });
          },
          py::arg("id"), "Removes a body.")
      .def(
          "set_velocity",
          [](const bodies& b, std::uint64_t id, const std::array<real, 3>& v) {
            b.session->change([&](world_type& w) {
              on_shape(w, b.shape, [&]<class Shape>(std::type_identity<Shape>) {
                w[handle<Shape>{system_id{id}}].set_velocity({v[0], v[1], v[2]});
              });
            });
          },
          py::arg("id"), py::arg("velocity"), "Sets the velocity of the centre of mass of a body.");
}

/// The bodies of a world.
template <class Session, class Class>
void bind_bodies(pybind11::module_& module, Class& world_class) {
  namespace py = pybind11;
  using driven = driven_world<Session>;
  using bodies = bodies_of_one_shape<Session>;
  py::class_<bodies> bodies_class(module, "Bodies", py::module_local(),
                                  "The bodies of one shape that are not global.");
  bodies_class.def_readonly("shape", &bodies::shape).def("__len__", [](const bodies& b) {
    return py::len(b.column("ids"));
  });
  bind_changes<Session>(bodies_class);
  bind_overlaps<Session>(bodies_class);
  for (const auto& [name, words] : column_words) {
    bodies_class.def_property_readonly(
        name, [name = name](const bodies& b) { return b.column(name); }, words);
    world_class.def_property_readonly(
        name,
        [name = name](driven& d) {
          const std::vector<std::string> shapes = movable_shapes(d.session->open());
          if (shapes.size() != 1) {
            std::string all;
            for (const std::string& s : shapes) all += (all.empty() ? "" : ", ") + s;
            throw py::attribute_error(
                compose("this world has bodies of several shapes ({}): write world.bodies['{}'].{}",
                        all, shapes.empty() ? "" : shapes.front(), name));
          }
          return column_of_shape(d.session->lent(), d.session->open(), shapes.front(), name);
        },
        words);
  }
  world_class.def_property_readonly(
      "bodies",
      [](driven& d) {
        py::dict all;
        for (const std::string& s : movable_shapes(d.session->open()))
          all[s.c_str()] = bodies{d.session, s};
        return all;
      },
      "The bodies by their shape, as world.bodies['sphere'].positions.");
}

/// Binds the steps of a world, from the beginning to the end.
template <class Session, class Class>
void bind_course(Class& world_class) {
  namespace py = pybind11;
  using driven = driven_world<Session>;
  world_class
      .def(
          "step",
          [](const py::object& self, std::uint64_t n) {
            auto& d = self.cast<driven&>();
            const std::uint64_t made = d.advance(n, self);
            if (made < n && made == 0) d.session->require_more();
            return made;
          },
          py::arg("n") = 1,
          "Makes n steps and returns their number, which is smaller if the set-up ends before. "
          "Other threads of Python run meanwhile.")
      .def(
          "run",
          [](const py::object& self) {
            auto& d = self.cast<driven&>();
            std::uint64_t made = 0;
            while (!d.session->over()) made += d.advance(1000, self);
            return made;
          },
          "Makes all steps that the set-up simulates, to its end; returns their number.")
      .def(
          "observe",
          [](driven& d, std::uint64_t every, py::function f) {
            if (every == 0)
              throw std::invalid_argument("observe needs a number of steps of 1 or more, not 0");
            if (d.observing)
              throw std::runtime_error(
                  "an observer added an observer to its own world: add it between the steps");
            d.observers.push_back({every, std::move(f)});
          },
          py::arg("every"), py::arg("f"),
          "Calls f(world) after each step whose number is a multiple of `every`.")
      .def(
          "close", [](driven& d) { d.session->close(); },
          "Ends the world and frees its memory; arrays that were taken from it stay valid.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](driven& d, const py::args&) { d.session->close(); });
  using world_type = typename Session::world_type;
  if constexpr (world_type::scenario_type::template has_feature<checkpoints>)
    world_class.def(
        "write_checkpoint",
        [](driven& d, const std::string& file) {
          const std::string& name = file_of_python(file, "write_checkpoint");
          d.session->change([&](world_type& w) { talus::write_checkpoint(w, name); });
        },
        py::arg("file"),
        "Writes the state to a file, from which World(restart=file) and --restart continue.");
}

}  // namespace detail

namespace python {

/// Adds the classes World, Bodies and, where the scenario has joints, Joint to a module. `set_up`
/// is the function that run<Scenario, Options> takes: a World runs it on a thread of its own, and
/// suspends it in world.simulate(...) after the steps that Python asks for. The keyword arguments
/// of World are the options of the program. Exceptions of the scene become those of Python:
/// invalid_argument ValueError, all others RuntimeError. docs/python.md describes the classes.
template <class Scenario, class Options = talus::options, class SetUp>
void scenario(pybind11::module_& module, SetUp set_up) {
  namespace py = pybind11;
  using session = detail::session<Scenario, Options, SetUp>;
  using driven = detail::driven_world<session>;
  // pybind11 looks for the functions of numpy when they are first used, below a lock that it keeps
  // while other threads run: two threads that took their first arrays at once would wait for ever.
  (void)py::dtype::of<real>();
  const auto name = module.attr("__name__").cast<std::string>();
  const std::string words =
      "A world of this scenario. Its arguments are the options of the "
      "program, with _ instead of -:\n\n" +
      detail::help_of<Scenario, Options>(name);
  py::class_<driven> world_class(module, "World", words.c_str(), py::module_local());
  const auto sessions = std::make_shared<std::vector<std::weak_ptr<session>>>();
  const auto end = std::make_shared<detail::end_of_python>();
  world_class.def(py::init([set_up, name, words, sessions, end](const py::kwargs& given) {
    const detail::end_of_python::at_work here(*end);
    auto made = std::make_shared<session>(set_up, name, detail::words_of(given, words), end);
    std::erase_if(*sessions, [](const auto& s) { return s.expired(); });
    sessions->push_back(made);
    made->begin();
    return driven{std::move(made)};
  }));
  // At the end of Python no set-up is left suspended.
  py::module_::import("atexit").attr("register")(py::cpp_function([sessions, end] {
    end->wait(std::chrono::seconds(5));
    for (const auto& one : std::vector(*sessions))  // close() lets other threads run
      if (const auto alive = one.lock()) try {
          alive->close();
        } catch (const std::exception& e) {  // the others are closed all the same
          PySys_FormatStderr("%s\n", e.what());
        }
  }));
  detail::bind_figures<session>(world_class);
  detail::bind_tables<session>(world_class);
  detail::bind_queries<session>(world_class);
  detail::bind_bodies<session>(module, world_class);
  detail::bind_course<session>(world_class);
  if constexpr (requires(detail::world_state<Scenario> & s) { s.joints.size(); }) {
    detail::bind_joints(module);
    world_class.def_property_readonly(
        "joints", [](driven& d) { return detail::joints_of(d.session); },
        "The joints, in the order in which they were joined.");
  }
}

}  // namespace python
}  // namespace talus
