#pragma once
// run<Scenario>(argc, argv, set_up): a scenario as a program, with options, progress and summary.
#include <algorithm>
#include <concepts>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "talus/core/clock.hpp"
#include "talus/observe/critical_dt.hpp"
#include "talus/observe/initial_overlap.hpp"
#include "talus/observe/monitors.hpp"
#include "talus/observe/progress.hpp"
#include "talus/observe/summary.hpp"
#include "talus/observe/time_series.hpp"
#include "talus/parallel/launch_settings.hpp"
#include "talus/parallel/launcher.hpp"
#include "talus/scene/detail/differing_results.hpp"
#include "talus/scene/detail/options_in_use.hpp"
#include "talus/scene/detail/run_guard.hpp"
#include "talus/scene/options.hpp"
#include "talus/scene/run_outputs.hpp"
#include "talus/world/world.hpp"

namespace talus {

/// The output of a run; defined by <talus/vtk.hpp>.
template <class Scenario>
class vtk_series;

namespace detail {

/// The program's name without its folders.
[[nodiscard, gnu::cold]] inline std::string program_name(const char* path) {
  const std::string name = path != nullptr ? path : "talus";
  return name.substr(name.find_last_of('/') + 1);
}

/// Says what a set-up has probably forgotten, on standard error.
[[gnu::cold]] inline void mention_forgotten(const std::string& name, bool stepped,
                                            const options& options) {
  if (stepped || options.steps == 0) return;
  std::fputs(
      (name + ": no step was made: call world.simulate({.steps = options.steps, .dt = options.dt}) "
              "at the end of the set-up\n")
          .c_str(),
      stderr);
}

/// Throws usage_error, alike on all ranks, where nothing takes the pictures that are asked for.
template <class Scenario>
[[gnu::cold]] void require_pictures(const world<Scenario>& w, const options& options) {
  if (!options.frames.empty() && !w.takes_pictures())
    throw usage_error(
        "this program takes no pictures: call take_pictures(world, options) before "
        "world.simulate(...), or leave out --frames");
}

/// Says where bodies begin inside each other, on standard error. Collective.
template <class Scenario>
[[gnu::cold]] void mention_overlap(const std::string& name, world<Scenario>& w) {
  if (w.steps() > 0) return;
  const std::string words = initial_overlap(w);
  if (!words.empty()) std::fputs(compose("{}: warning: {}\n", name, words).c_str(), stderr);
}

/// Says that the time step is not stable for soft contacts, on standard error. Collective.
template <class Scenario>
[[gnu::cold]] void mention_step(const std::string& name, world<Scenario>& w) {
  if (w.steps() > 0) return;
  const std::string words = unstable_step(w, state_of(w).dt);
  if (w.rank() == 0 && !words.empty())
    std::fputs(compose("{}: warning: {}\n", name, words).c_str(), stderr);
}

/// Steps from one reading of the monitors for the progress line to the next: all ranks take part.
inline constexpr std::uint64_t note_every = 50;

/// The step with which the run ends, as far as is known: what simulate() was asked for. Where it is
/// called for one part after another, --steps says more.
template <class Scenario>
[[nodiscard]] std::uint64_t planned_steps(const world<Scenario>& w, const options& options) {
  return w.simulations() > 1 ? std::max<std::uint64_t>(w.last_step(), options.steps)
                             : w.last_step();
}

/// The checkpoints that the options ask for. Collective.
template <class Scenario, class Options>
void attach_checkpoints(world<Scenario>& w, const Options& options, progress_line& progress,
                        time_series& table) {
  if constexpr (Scenario::template has_feature<checkpoints>) {
    static_assert(complete<checkpoint_files<Scenario>>,
                  "run needs what writes the checkpoints of its scenario, which names "
                  "features<checkpoints>: write #include <talus/checkpoint.hpp>");
    if constexpr (complete<checkpoint_files<Scenario>>) {
      if (options.checkpoint.empty() && options.restart.empty()) return;
      checkpoint_plan plan;
      plan.to = options.checkpoint;
      plan.every = options.checkpoint_every;
      plan.last = options.steps;
      plan.from = options.restart;
      plan.force = options.force;
      plan.quiet = options.quiet;
      plan.tell = [](const std::string& words) { std::fputs((words + "\n").c_str(), stderr); };
      plan.restarted = [&](std::uint64_t step) {
        progress.begin_at(step);
        table.go_on_from(step, options.csv_every);
      };
      checkpoint_files<Scenario>::attach(w, plan);
    }
  }
}

/// The output that the options ask for. Collective.
template <class Scenario, class Options>
void attach_output(world<Scenario>& w, const Options& options) {
  if constexpr (Scenario::template has_feature<vtk_output>) {
    static_assert(complete<vtk_series<Scenario>>,
                  "run needs what writes the output of its scenario, which names "
                  "features<vtk_output>: write #include <talus/vtk.hpp>");
    if constexpr (complete<vtk_series<Scenario>>) {
      if (options.output.empty()) return;
      const auto series = std::make_shared<vtk_series<Scenario>>(
          w, options.output, !options.restart.empty(),
          typename vtk_series<Scenario>::content{.surfaces = options.output_surfaces,
                                                 .force = options.force});
      if (w.rank() == 0 && series->replaces() && !options.quiet)
        std::fputs(
            compose("--output {} replaces a series of an earlier run\n", options.output).c_str(),
            stderr);
      const auto write = [&w, series, every = options.output_every] {
        if (w.steps() % every == 0) series->write();
      };
      w.before_simulating([series, write] { series->go_on(), write(); });
      w.after_each_step(write);
    }
  }
}

/// One rank of the program: set-up, steps with progress, figures. Returns the exit code.
template <class Scenario, class Options, class SetUp>
int run_rank(typename Scenario::transport::link& link, const Options& options,
             const std::string& name, SetUp& set_up) {
  world<Scenario> w(link);
  if constexpr (!std::is_void_v<typename Scenario::solver_on_request>)
    if (options.reproducible) w.use_solver_on_request();
  if constexpr (!Scenario::contact_law::soft) {
    w.solver().iterations = options.iterations;
    w.solver().tolerance = options.tolerance;
    if (options.max_iterations > 0) w.solver().max_iterations = options.max_iterations;
  }
  w.seed(options.seed);
  const bool speaks = link.rank() == 0;
  const std::string replaced = speaks ? inspect_outputs(options) : "";

  progress_line progress(speaks && !options.quiet ? stderr : nullptr);
  time_series table(options.csv, speaks, !options.restart.empty());
  w.before_simulating([&] { require_pictures(w, options); });
  w.before_simulating([&] { table.begin(w); });
  if (!options.quiet) w.before_simulating([&] { mention_overlap(name, w); });
  if constexpr (Scenario::contact_law::soft)
    if (!options.quiet) w.before_simulating([&] { mention_step(name, w); });
  std::string note;
  w.after_observers([&] {
    if constexpr (has_monitors<Scenario>)
      if (!options.quiet && (w.steps() % note_every == 0 || w.steps() == w.last_step()))
        note = measure_monitors(w).text;
    progress.update(w.steps(), planned_steps(w, options), note);
    if (w.steps() % options.csv_every == 0) table.sample(w);
  });
  attach_checkpoints(w, options, progress, table);
  attach_output(w, options);
  if (!options.quiet) std::fputs(replaced.c_str(), stderr);
  run_place place{.rank = link.rank()};
  const exit_guard guard(place, name, options.json);
  w.after_each_step([&] {
    place.step = w.steps();
    if constexpr (requires { link.note_step(place.step); }) link.note_step(place.step);
  });
  const double cpu = thread_seconds();
  const double start = wall_seconds();
  results own;
  const auto set_up_and_simulate = [&] {
    try {
      if constexpr (std::is_void_v<decltype(set_up(w, options))>)
        set_up(w, options);
      else
        own = set_up(w, options);
    } catch (const std::exception&) {
      throw;
    } catch (const ended_by_signal&) {
      throw;
    } catch (const abi::__forced_unwind&) {  // the thread is cancelled
      throw;
    } catch (...) {
      rethrow_with_words(place);
    }
  };
  if constexpr (Scenario::template has_feature<checkpoints>) {
    try {
      set_up_and_simulate();
    } catch (const ended_by_signal& end) {
      if (speaks)
        std::fputs(
            compose("{}: ended by {} in step {}; go on with --restart {}\n", name,
                    end.signal == SIGINT ? "SIGINT" : "SIGTERM", end.step, options.checkpoint)
                .c_str(),
            stderr);
      return 128 + end.signal;  // as a shell says it
    }
    w.require_restarted();
  } else {
    set_up_and_simulate();
  }
  require_pictures(w, options);
  progress.finish(w.steps(), note);
  const double wall = wall_seconds() - start;
  if (speaks && !options.quiet) mention_forgotten(name, w.steps() > 0, options);

  if (w.steps() == 0) w.synchronize();
  if constexpr (!std::is_void_v<decltype(set_up(w, options))>)
    if (!options.quiet) mention_results(name, link, own);
  table.sample(w);
  talus::summary figures = summarize(w, thread_seconds() - cpu, wall);
  figures.scenario = name;
  figures.own = std::move(own);
  if (!speaks) return 0;
  if (!options.quiet) std::fputs(to_text(figures).c_str(), stdout);
  if (options.json.empty()) return 0;
  try {
    write_output(options.json, to_json(figures), results_output, options.force);
  } catch (const std::exception& e) {
    fail<std::runtime_error>("the results {} (--json) {}", options.json, e.what());
  }
  return 0;
}

template <class Type>
inline constexpr bool is_scenario = requires {
  typename Type::contact_law;
  typename Type::transport;
};

/// Refuses a transport whose header is missing, before a world stumbles over it.
template <class Scenario, bool IsScenario>
inline constexpr bool linked = false;
template <class Scenario>
inline constexpr bool linked<Scenario, true> = [] {
  constexpr bool here = complete<typename Scenario::transport>;
  static_assert(
      here,
      "run needs the transport of the scenario, which is threads unless it names another: "
      "write #include <talus/talus.hpp>, or <talus/mpi.hpp> for mpi and as_launched");
  return here;
}();

template <class Scenario, class Options, class SetUp>
int run_checked(int argc, char** argv, SetUp& set_up) {
  const std::string name = program_name(argc > 0 ? argv[0] : nullptr);
  const bool speaks = find_launcher().rank == 0;
  const auto complain = [&](const std::string& message) {
    std::fputs((name + ": " + message + "\n").c_str(), stderr);
    std::fflush(stderr);
  };
  try {
    const Options chosen = parse<Options>(argc, argv, {}, "", withdraw_options<Scenario>);
    launch_settings settings;
    settings.argc = &argc;
    settings.argv = &argv;
    settings.ranks = chosen.ranks;
    settings.default_ranks = typename Scenario::decomposition{}.size();
    settings.report = complain;
    settings.patience = chosen.patience;
    settings.give_up = chosen.give_up;
    int code = 0;
    Scenario::transport::launch(settings, [&](auto& link) {
      const int of_rank = run_rank<Scenario>(link, chosen, name, set_up);
      if (link.rank() == 0 || find_launcher().size > 1) code = of_rank;
    });
    return code;
  } catch (const help_requested& help) {
    if (speaks) std::fputs(help.what(), stdout);
    return 0;
  } catch (const usage_error& error) {
    if (speaks) complain(error.what());
    return 2;
  } catch (const aborted&) {  // said by the rank that failed
    return 1;
  } catch (const std::exception& error) {
    complain(error.what());
    return 1;
  } catch (...) {
    complain("an exception that is no std::exception");
    return 1;
  }
}

}  // namespace detail

/// Runs a scenario as the program was started: serially, with ranks inside the process (--ranks),
/// or under mpirun, as its transport allows. `set_up(world, options)` fills the world and
/// simulates; it runs on every rank, and may return `results` of its own to be reported. Reads the
/// command line (see `options`), shows progress, and reports at the end. Returns the exit code for
/// main(): errors are printed once, whichever rank they come from. exit() in a callback ends the
/// process with a message and a code other than 0.
template <class Scenario, class Options = options, class SetUp>
int run(int argc, char** argv, SetUp&& set_up) {
  constexpr bool scene = detail::is_scenario<Scenario>;
  constexpr bool chosen = std::derived_from<Options, talus::options>;
  static_assert(scene,
                "run takes a scenario first: write using scene = scenario<...>, then "
                "run<scene>(argc, argv, set_up)");
  static_assert(chosen,
                "run takes options that derive from talus::options: write struct my_options : "
                "talus::options { ... }");
  if constexpr (scene && chosen && detail::linked<Scenario, scene>) {
    constexpr bool fits = requires(world<Scenario> & w, const Options& o) { set_up(w, o); };
    static_assert(fits,
                  "run takes a function of the world and the options: write [](auto& world, const "
                  "auto& options) { ... }");
    if constexpr (fits) return detail::run_checked<Scenario, Options>(argc, argv, set_up);
  }
  return 1;
}

/// Refuses a run of no scenario.
template <class SetUp>
int run(int, char**, SetUp&&) {
  static_assert(sizeof(SetUp) == 0,
                "run needs the scenario between angle brackets: write run<scene>(argc, argv, "
                "set_up), where using scene = scenario<...>");
  return 1;
}

}  // namespace talus
