#pragma once
// The definitions of options.hpp, in the compiled part or in each program.
#include <cmath>
#include <string>
#include <utility>

#include "talus/core/linkage.hpp"
#include "talus/scene/detail/shared_names.hpp"
#include "talus/scene/options.hpp"

namespace talus {

namespace detail {

TALUS_INLINE double seconds_in(const std::string& text) {
  const auto refuse = [&] {
    fail<usage_error>(
        "--time-limit needs a wall time above 0, as in 3600 (seconds), 45m, 1h30m or 2d, but is "
        "'{}'; see --help",
        text);
  };
  double sum = 0, last_unit = 1e9;
  std::size_t at = 0;
  if (text.empty()) refuse();
  while (at < text.size()) {
    double number = 0, digit = 1;
    const std::size_t from = at;
    bool point = false;
    for (; at < text.size() && ((text[at] >= '0' && text[at] <= '9') || text[at] == '.'); ++at) {
      if (text[at] == '.') {
        if (point) refuse();
        point = true;
      } else if (point) {
        number += (digit /= 10) * (text[at] - '0');
      } else {
        number = 10 * number + (text[at] - '0');
      }
    }
    if (at == from || (point && at == from + 1)) refuse();
    double unit = 1;
    if (at < text.size()) {
      const char letter = text[at++];
      unit = letter == 's'   ? 1
             : letter == 'm' ? 60
             : letter == 'h' ? 3600
             : letter == 'd' ? 86400
                             : 0;
    } else if (from != 0) {
      refuse();  // a number without a unit stands alone
    }
    if (unit == 0 || unit >= last_unit) refuse();
    last_unit = unit;
    sum += unit * number;
  }
  if (!(sum > 0) || !std::isfinite(sum)) refuse();
  return sum;
}

}  // namespace detail

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
  cli.add("--colour", colour, "of bodies in pictures: by material, rank or speed");
  cli.add("--show-copies", copies, "pictures show shadow copies too");
  cli.add("--show-domains", domains, "pictures show what each rank owns");
  cli.add("--checkpoint", checkpoint,
          "keep the state of the run in this file; SIGUSR1, SIGTERM and Ctrl-C write it too");
  cli.add("--checkpoint-every", checkpoint_every, "steps from one version of it to the next", 1);
  cli.add("--restart", restart, "go on from this checkpoint");
  cli.add("--output", output, "write bodies and contacts for ParaView: NAME.hdf.series");
  cli.add("--output-every", output_every,
          "steps from one output to the next; the end of the run has one too", 1);
  cli.add(
      "--output-surfaces", output_surfaces,
      "with the faces of boxes, capsules and all that are no spheres: NAME_surfaces.hdf.series");
  cli.add("--view", view, "write a page that shows the run in a browser to this file");
  cli.add("--view-every", view_every,
          "steps from one frame of it to the next (default: about 200 frames)", 1);
  cli.add("--view-contacts", view_contacts, "with each contact: a page up to four times as large");
  cli.add("--force", force, "outputs replace files that talus did not write");
  cli.add("--until", until,
          "end when all bodies are at \"rest\", or \"steady:NAME\": see docs/runs.md");
  cli.add("--until-speed", until_speed,
          "largest speed of bodies at rest (default: they rise by 1e-4 radii)", 1e-12);
  cli.add(
      "--until-time", until_time,
      "how long bodies are at rest (default: a fall by their diameter), or the window of what is "
      "steady",
      1e-12);
  cli.add("--until-within", until_within, "change of what is steady, as a part of its size", 0, 1);
  cli.add("--until-every", until_every, "steps from one look at it to the next", 1);
  cli.add("--time-limit", time_limit,
          "end after so much wall time, as in 3600 or 1h30m, with the exit code 75");
  cli.add("--dry-run", dry_run, "estimate time and memory in a short trial, and write nothing");
  cli.add("--log", log, "write what the run says into this file too, also with --quiet");
  cli.check([this, &cli] {
    if (!time_limit.empty()) (void)detail::seconds_in(time_limit);
    const bool steady = until.starts_with("steady:") && until.size() > 7;
    if (!until.empty() && until != "rest" && !steady)
      throw usage_error(
          "--until takes rest, or steady:NAME for a recorded value, kinetic_energy, "
          "potential_energy or max_speed, but is '" +
          until + "'; see --help");
    if (steady && until_time == 0)
      throw usage_error(
          "--until steady:NAME needs --until-time, the length of its window; see --help");
    if (until.empty())
      for (const char* name : {"--until-speed", "--until-time", "--until-within", "--until-every"})
        if (cli.given(name)) throw usage_error(std::string(name) + " needs --until; see --help");
    if (checkpoint.empty() && checkpoint_every > 0)
      throw usage_error("--checkpoint-every needs --checkpoint FILE; see --help");
    const auto needs = [&cli](const std::string& file, const char* name, const char* other) {
      if (file.empty() && cli.given(name))
        throw usage_error(std::string(name) + " needs " + other + "; see --help");
    };
    if (give_up > 0 && patience == 0)
      throw usage_error("--give-up needs a --patience above 0; see --help");
    needs(csv, "--csv-every", "--csv FILE");
    for (const char* name : {"--every", "--show-copies", "--show-domains"})
      needs(frames, name, "--frames DIR");
    if (view.empty()) needs(frames, "--colour", "--frames DIR or --view FILE");
    if (tolerance == 0 && cli.given("--max-iterations"))
      throw usage_error("--max-iterations needs --tolerance; see --help");
    needs(output, "--output-every", "--output NAME");
    for (const char* name : {"--view-every", "--view-contacts"}) needs(view, name, "--view FILE");
    const detail::named_file files[] = {{"--view", view},       {"--json", json},
                                        {"--csv", csv},         {"--checkpoint", checkpoint},
                                        {"--restart", restart}, {"--log", log},
                                        {"--output", output},   {"--frames", frames}};
    detail::refuse_shared_names(files);
    if (output.empty() && output_surfaces)
      throw usage_error("--output-surfaces needs --output NAME; see --help");
    if (!colour.empty() && colour != "rank" && colour != "speed" && colour != "material")
      throw usage_error("--colour must be material, rank or speed, but is '" + colour +
                        "'; see --help");
  });
}

}  // namespace talus
