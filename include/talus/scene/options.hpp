#pragma once
// The options of every example.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "talus/scene/command_line.hpp"
#include "talus/scene/run_outputs.hpp"

namespace talus {

/// What every example can be told. A scenario derives from it to set defaults and add its own:
///   struct well_options : talus::options {
///     int spheres = 3000;
///     well_options() { steps = 6000; }
///     void describe(auto& cli) {
///       options::describe(cli);
///       cli.add("--spheres", spheres, "number of spheres", 0);
///     }
///   };
struct options {
  std::size_t steps = 1000;          ///< time steps
  double dt = 0.005;                 ///< length of a step, in units of time
  int ranks = 0;                     ///< ranks to start; 0: as the decomposition says
  int iterations = 10;               ///< of the contact solver, per step
  double tolerance = 0;              ///< contact residual to iterate to; 0: fixed iterations
  int max_iterations = 0;            ///< at most, with a tolerance; 0: the solver's own limit
  std::uint64_t seed = 1;            ///< of all random numbers
  std::string json;                  ///< file for the results; empty: none
  std::string csv;                   ///< file for a time series; empty: none
  std::size_t csv_every = 10;        ///< steps between its lines
  bool reproducible = false;         ///< the same bits on any number of ranks
  bool quiet = false;                ///< no progress, no summary
  double patience = 60;              ///< seconds that a rank waits before a report; 0: none
  double give_up = 0;                ///< further seconds before the run ends; 0: it does not
  std::string frames;                ///< folder for pictures; empty: none
  std::size_t every = 100;           ///< steps between pictures
  std::string colour;                ///< "rank" or "speed"; empty: as the scene likes it
  bool copies = false;               ///< pictures show shadow copies
  bool domains = false;              ///< pictures show what each rank owns
  std::string checkpoint;            ///< file for the state of the run; empty: none
  std::size_t checkpoint_every = 0;  ///< steps between its versions; 0: on signals and at the end
  std::string restart;               ///< checkpoint to go on from; empty: from the beginning
  std::string output;                ///< files for ParaView begin with it; empty: none
  std::size_t output_every = 100;    ///< steps between them
  bool output_surfaces = false;      ///< with the faces of bodies that are no spheres
  bool force = false;                ///< outputs replace files that talus did not write

  [[gnu::cold]] void describe(command_line& cli) {
    cli.add("--steps", steps, "time steps");
    cli.add_positive("--dt", dt, "length of a time step");
    cli.add("--ranks", ranks, "ranks to start (default: as the decomposition says)", 1);
    cli.add("--iterations", iterations, "iterations of the solver per step", 1);
    cli.add("--tolerance", tolerance, "contact residual to iterate to (default: fixed iterations)",
            1e-14, 0.5);
    cli.add("--max-iterations", max_iterations, "at most, with --tolerance (default: 1000)", 1);
    cli.add("--seed", seed, "seed of all random numbers");
    cli.add("--json", json, "write the results to this file");
    cli.add("--csv", csv, "write a time series, comma-separated, to this file");
    cli.add("--csv-every", csv_every, "steps from one of its lines to the next", 1);
    cli.add("--reproducible", reproducible, "the same bits on any number of ranks; slower");
    cli.add("--quiet", quiet, "no progress, no summary");
    cli.add("--patience", patience,
            "seconds that a rank waits for others before they are named; 0: never", 0);
    cli.add("--give-up", give_up,
            "further seconds before the run ends (default: it goes on waiting)", 0.001);
    cli.add("--frames", frames, "write pictures for POV-Ray into this folder");
    cli.add("--every", every, "steps from one picture to the next", 1);
    cli.add("--colour", colour, "of bodies in pictures: by rank or by speed");
    cli.add("--show-copies", copies, "pictures show shadow copies too");
    cli.add("--show-domains", domains, "pictures show what each rank owns");
    cli.add("--checkpoint", checkpoint,
            "keep the state of the run in this file; SIGUSR1, SIGTERM and Ctrl-C write it too");
    cli.add("--checkpoint-every", checkpoint_every, "steps from one version of it to the next", 1);
    cli.add("--restart", restart, "go on from this checkpoint");
    cli.add("--output", output, "write bodies and contacts for ParaView: NAME.hdf.series");
    cli.add("--output-every", output_every, "steps from one output to the next", 1);
    cli.add(
        "--output-surfaces", output_surfaces,
        "with the faces of boxes, capsules and all that are no spheres: NAME_surfaces.hdf.series");
    cli.add("--force", force, "outputs replace files that talus did not write");
    cli.check([this, &cli] {
      if (checkpoint.empty() && checkpoint_every > 0)
        throw usage_error("--checkpoint-every needs --checkpoint FILE; see --help");
      const auto needs = [&cli](const std::string& file, const char* name, const char* other) {
        if (file.empty() && cli.given(name))
          throw usage_error(std::string(name) + " needs " + other + "; see --help");
      };
      if (give_up > 0 && patience == 0)
        throw usage_error("--give-up needs a --patience above 0; see --help");
      needs(csv, "--csv-every", "--csv FILE");
      for (const char* name : {"--every", "--colour", "--show-copies", "--show-domains"})
        needs(frames, name, "--frames DIR");
      if (tolerance == 0 && cli.given("--max-iterations"))
        throw usage_error("--max-iterations needs --tolerance; see --help");
      needs(output, "--output-every", "--output NAME");
      detail::refuse_shared_files({{"--json", json}, {"--csv", csv}, {"--checkpoint", checkpoint}});
      detail::refuse_shared_files({{"--json", json}, {"--csv", csv}, {"--restart", restart}});
      if (output.empty() && output_surfaces)
        throw usage_error("--output-surfaces needs --output NAME; see --help");
      if (!colour.empty() && colour != "rank" && colour != "speed")
        throw usage_error("--colour must be rank or speed, but is '" + colour + "'; see --help");
    });
  }
};

/// Reads a command line; `defaults` holds the values of what it does not name. Throws
/// help_requested and usage_error, and never ends the program. `adapt(line, options)` may withdraw
/// options that do nothing in this program.
template <class Options = options, class Adapt = void (*)(command_line&, const Options&)>
[[nodiscard]] Options parse(
    int argc, const char* const* argv, Options defaults = {}, std::string_view description = "",
    Adapt adapt = [](command_line&, const Options&) {}) {
  command_line cli(description);
  defaults.describe(cli);
  adapt(cli, std::as_const(defaults));
  cli.parse(argc, argv);
  return defaults;
}

}  // namespace talus
