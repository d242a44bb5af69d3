#pragma once
// The classes of a Python module that drives a compiled scenario.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/observe/digest.hpp"
#include "talus/observe/motion.hpp"
#include "talus/observe/summary.hpp"
#include "talus/observe/summary_json.hpp"
#include "talus/python/arrays.hpp"
#include "talus/python/joints.hpp"
#include "talus/python/made_objects.hpp"
#include "talus/python/session.hpp"
#include "talus/scene/options.hpp"

namespace talus {

/// Writes a checkpoint; defined by <talus/checkpoint.hpp>.
template <class Scenario>
void write_checkpoint(world<Scenario>& w, const std::string& file);

namespace detail {

/// A value of Python as that of a type. Throws type_error with the sentence if it is none.
template <class Type>
[[nodiscard]] Type value_from(const pybind11::handle& value, const char* sentence) {
  try {
    return value.cast<Type>();
  } catch (const pybind11::cast_error&) {
    throw pybind11::type_error(sentence);
  }
}
inline constexpr const char* sizes_are_numbers =
    "a shape is given by numbers before the others, such as its radius";
/// Throws invalid_argument if the text is the name of a pipe: the thread that waits for its other
/// end cannot be interrupted.
inline void refuse_pipe(const std::string& text, const std::string& what) {
  std::error_code none;
  if (std::filesystem::is_fifo(text, none))
    fail<std::invalid_argument>(
        "{} names the pipe {}, whose other end Python cannot wait for: "
        "name a file",
        what, quoted_text(text));
}
/// The name of a file that Python gives to a function. Throws invalid_argument for one that is
/// empty, or that the system would cut, and for a pipe.
[[nodiscard]] inline const std::string& file_of_python(const std::string& file,
                                                       const char* function) {
  if (file.empty() || file.find('\0') != std::string::npos)
    fail<std::invalid_argument>("{} needs the name of a file, but is given {}", function,
                                quoted_text(file));
  refuse_pipe(file, function);
  return file;
}

/// The words of a command line for the keyword arguments of Python: csv_every=5 is --csv-every=5,
/// unless `help`, the list of the options, has --csv_every.
[[nodiscard]] inline std::vector<std::string> words_of(const pybind11::kwargs& given,
                                                       const std::string& help) {
  namespace py = pybind11;
  std::vector<std::string> words;
  bool quiet = false;
  for (const auto& [key, value] : given) {
    auto name = key.cast<std::string>();
    quiet |= name == "quiet";
    const auto has = [&](const char* end) {
      return help.find("\n  --" + name + end) != std::string::npos;
    };
    if (!has(" ") && !has("=") && !has("\n")) std::replace(name.begin(), name.end(), '_', '-');
    if (value.is_none()) continue;
    if (PyBytes_Check(value.ptr()) || PyByteArray_Check(value.ptr()))
      throw pybind11::type_error(compose("{} needs a text, but is given bytes: decode them", name));
    const std::string text =
        py::isinstance<py::bool_>(value) ? value.cast<bool>() ? "true" : "false"
        : py::isinstance<py::float_>(value)
            ? py::repr(value).cast<std::string>()
            : value_from<std::string>(py::str(value),
                                      "an option is given a text that is no Unicode");
    if (text.find('\0') != std::string::npos)
      fail<std::invalid_argument>("{} needs a text without zero bytes, but is {}", name,
                                  quoted_text(text));
    refuse_pipe(text, name);
    words.push_back("--" + name + "=" + text);
  }
  if (!quiet) words.emplace_back("--quiet=true");
  return words;
}

/// What --help prints of the options.
template <class Scenario, class Options>
[[nodiscard]] std::string help_of(const std::string& name) {
  const char* const arguments[] = {name.c_str(), "--help"};
  try {
    (void)parse<Options>(2, arguments, {}, "", withdraw_options<Scenario>);
  } catch (const help_requested& help) {
    return help.what();
  }
  return {};
}

/// A world, with the functions of Python that are called between its steps.
template <class Session>
struct driven_world {
  struct observer {
    std::uint64_t every;
    pybind11::function f;
  };
  std::shared_ptr<Session> session;
  std::vector<observer> observers{};
  bool observing = false;

  /// Makes n steps, or fewer if the set-up ends before, and calls the observers after those that
  /// are multiples of their numbers. Returns their number. `self` is this world in Python.
  std::uint64_t advance(std::uint64_t n, const pybind11::object& self) {
    if (observing)
      throw std::runtime_error("an observer made steps in its own world: it may only look at it");
    const end_of_python::at_work here(session->end());
    std::uint64_t made = 0;
    while (made < n && !session->over()) {
      const std::uint64_t now = session->open().steps();
      std::uint64_t part = n - made;
      for (const observer& o : observers) part = std::min(part, o.every - now % o.every);
      const std::uint64_t steps = session->step(part);
      if (steps == 0) break;
      made += steps;
      observe(self);
    }
    return made;
  }

 private:
  void observe(const pybind11::object& self) {
    struct mark {
      bool& set;
      explicit mark(bool& b) : set(b) { set = true; }
      ~mark() { set = false; }
    } const under_way(observing);
    const std::uint64_t now = session->open().steps();
    for (const observer& o : observers)
      if (now % o.every == 0) call_of_thread(o.f, self);
  }
};

/// The bodies of one shape.
template <class Session>
struct bodies_of_one_shape {
  std::shared_ptr<Session> session;
  std::string shape;
  [[nodiscard]] pybind11::array column(const std::string& name) const {
    return column_of_shape(session->lent(), session->open(), shape, name);
  }
};

}  // namespace detail
}  // namespace talus

/// Functions of Python refuse such an object without a value.
template <class Session>
class pybind11::detail::type_caster<talus::detail::driven_world<Session>>
    : public talus::detail::caster_of_made_objects<talus::detail::driven_world<Session>> {};
/// Functions of Python refuse such an object without a value.
template <class Session>
class pybind11::detail::type_caster<talus::detail::bodies_of_one_shape<Session>>
    : public talus::detail::caster_of_made_objects<talus::detail::bodies_of_one_shape<Session>> {};

namespace talus::detail {

inline constexpr std::pair<const char*, const char*> column_words[] = {
    {"positions", "Centres of mass, one row for each body. Read-only, without a copy."},
    {"velocities", "Velocities of the centres of mass, likewise."},
    {"angular_velocities", "Angular velocities in the world frame, likewise."},
    {"orientations", "Unit quaternions x, y, z, w, likewise, where bodies have orientations."},
    {"ids", "Ids of the bodies, likewise. The order of the bodies may change from step to step."},
    {"radii", "Radii, likewise, of shapes that have one."}};

}  // namespace talus::detail
