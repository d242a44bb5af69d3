#pragma once
// The options of every example.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "talus/concepts.hpp"
#include "talus/scene/command_line.hpp"
#include "talus/scene/option_groups.hpp"
#include "talus/scene/settings_file.hpp"

namespace talus {

/// The options of every program made with run. A scenario derives from it to set defaults and add
/// its own:
///   struct well_options : talus::options {
///     int spheres = 3000;
///     well_options() { steps = 6000; }
///     void describe(auto& cli) {
///       options::describe(cli);
///       cli.add("--spheres", spheres, "number of spheres", 0);
///     }
///   };
struct options {
  std::size_t steps = 1000;    ///< time steps
  double dt = 0.005;           ///< length of a step, in units of time
  int ranks = 0;               ///< ranks to start; 0: the number of the decomposition
  int iterations = 10;         ///< of the contact solver, per step
  double tolerance = 0;        ///< contact residual to iterate to; 0: fixed iterations
  int max_iterations = 0;      ///< at most, with a tolerance; 0: the solver's own limit
  std::uint64_t seed = 1;      ///< of all random numbers
  std::string json;            ///< file for the results; empty: none
  std::string csv;             ///< file for a time series; empty: none
  std::size_t csv_every = 10;  ///< steps between its lines
  bool reproducible = false;   ///< the same bits on any number of ranks
  bool quiet = false;          ///< no progress, no summary
  double patience = 60;        ///< seconds that a rank waits before a report; 0: none
  double give_up = 0;          ///< further seconds before the run ends; 0: it does not
  std::string frames;          ///< folder for pictures; empty: none
  std::size_t every = 100;     ///< steps between pictures
  std::string colour;          ///< "material", "rank" or "speed"; empty: the default of the scene
  bool copies = false;         ///< pictures show shadow copies
  bool domains = false;        ///< pictures show the domain of each rank
  std::string checkpoint;      ///< file for the state of the run; empty: none
  std::size_t checkpoint_every = 0;  ///< steps between its versions; 0: on signals and at the end
  std::string restart;               ///< checkpoint to continue from; empty: from the beginning
  std::string output;                ///< files for ParaView begin with it; empty: none
  std::size_t output_every = 100;    ///< steps between them
  bool output_surfaces = false;      ///< with the faces of bodies other than spheres
  std::string view;                  ///< page for a browser; empty: none
  std::size_t view_every = 0;        ///< steps between its frames; 0: about 200 frames
  bool view_contacts = false;        ///< with each contact, not only the force on each body
  bool force = false;                ///< outputs replace files that talus did not write
  std::string until;                 ///< "rest" or "steady:NAME"; empty: all steps are made
  double until_speed = 0;            ///< of bodies at rest; 0: from gravity and sizes
  double until_time = 0;             ///< at rest, or window of a steady observable, units of time
  double until_within = 0.01;        ///< change of a steady observable, part of its size
  std::size_t until_every = 10;      ///< steps between looks at it
  std::string time_limit;            ///< of wall time, as in 3600 or 1h30m; empty: none
  bool dry_run = false;              ///< only estimates time and memory; writes nothing
  std::string log;                   ///< file for what the run says; empty: none
  std::string configuration;         ///< of parse(): all options with their values, as TOML

  [[gnu::cold]] void describe(command_line& cli);
};

namespace detail {

/// Seconds in the text of --time-limit, as in "3600", "90s", "45m", "1h30m" or "2d". Throws
/// usage_error.
[[nodiscard, gnu::cold]] double seconds_in(const std::string& text);

template <class Options>
[[nodiscard]] constexpr settings_reader* reader_of_settings() {
#ifdef TALUS_COMPILED
  return &read_settings;
#else
  if constexpr (complete<settings_file<Options> >)
    return &settings_file<Options>::read;
  else
    return nullptr;
#endif
}

}  // namespace detail

/// Reads a command line, with the files that it names; `defaults` holds the values of options that
/// it omits. Throws help_requested and usage_error, and never ends the program. `adapt(line,
/// options)` may withdraw options without effect in this program.
template <class Options = options, class Adapt = void (*)(command_line&, const Options&)>
[[nodiscard]] Options parse(
    int argc, const char* const* argv, Options defaults = {}, std::string_view description = "",
    Adapt adapt = [](command_line&, const Options&) {}) {
  command_line cli(description);
  defaults.describe(cli);
  cli.add_settings(detail::reader_of_settings<Options>());
  adapt(cli, std::as_const(defaults));
  cli.parse(argc, argv);
  defaults.configuration = cli.configuration();
  return defaults;
}

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/options_definitions.hpp"
#endif
