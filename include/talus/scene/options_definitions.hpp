#pragma once
// The definitions of options.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/scene/options.hpp"

namespace talus {

TALUS_INLINE void options::describe(command_line& cli) {
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
  cli.add("--give-up", give_up, "further seconds before the run ends (default: it goes on waiting)",
          0.001);
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
  cli.add("--view", view, "write a page that shows the run in a browser to this file");
  cli.add("--view-every", view_every,
          "steps from one frame of it to the next (default: about 200 frames)", 1);
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
    needs(view, "--view-every", "--view FILE");
    detail::refuse_shared_files({{"--view", view}, {"--json", json}});
    detail::refuse_shared_files({{"--view", view}, {"--csv", csv}});
    detail::refuse_shared_files({{"--view", view}, {"--checkpoint", checkpoint}});
    detail::refuse_shared_files({{"--view", view}, {"--restart", restart}});
    detail::refuse_shared_files({{"--json", json}, {"--csv", csv}, {"--checkpoint", checkpoint}});
    detail::refuse_shared_files({{"--json", json}, {"--csv", csv}, {"--restart", restart}});
    if (output.empty() && output_surfaces)
      throw usage_error("--output-surfaces needs --output NAME; see --help");
    if (!colour.empty() && colour != "rank" && colour != "speed")
      throw usage_error("--colour must be rank or speed, but is '" + colour + "'; see --help");
  });
}

}  // namespace talus
