#pragma once
// run<Scenario>(argc, argv, set_up): a scenario as a program, with options, progress and summary.
#include <fcntl.h>

#include <algorithm>
#include <concepts>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/clock.hpp"
#include "talus/core/output_file.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/io/run_signals.hpp"
#include "talus/observe/critical_dt.hpp"
#include "talus/observe/half_frictionless.hpp"
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
#include "talus/scene/detail/run_view.hpp"
#include "talus/scene/detail/unused_steps.hpp"
#include "talus/scene/dry_run.hpp"
#include "talus/scene/options.hpp"
#include "talus/scene/run_configuration.hpp"
#include "talus/scene/run_log.hpp"
#include "talus/scene/run_outputs.hpp"
#include "talus/scene/time_limit.hpp"
#include "talus/scene/until.hpp"
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
[[gnu::cold]] inline void mention_forgotten(run_log& log, const std::string& name, bool stepped,
                                            const options& options) {
  if (stepped || options.steps == 0) return;
  log.say(name +
              ": no step was made: call world.simulate({.steps = options.steps, .dt = "
              "options.dt}) at the end of the set-up\n",
          options.quiet);
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
[[gnu::cold]] void mention_overlap(run_log& log, const std::string& name, world<Scenario>& w,
                                   bool quiet) {
  if (w.steps() > 0) return;
  const std::string words = initial_overlap(w);
  if (!words.empty()) log.say(compose("{}: warning: {}\n", name, words), quiet);
}

/// Says which material is frictionless in name only, on standard error. Collective.
template <class Scenario>
[[gnu::cold]] void mention_friction(run_log& log, const std::string& name, world<Scenario>& w,
                                    bool quiet) {
  if (w.steps() > 0) return;
  const std::string words = half_frictionless(w);
  if (w.rank() == 0 && !words.empty()) log.say(compose("{}: warning: {}\n", name, words), quiet);
}

/// Says what `words` says of the table of --csv, on standard error.
[[gnu::cold]] inline void mention_table(run_log& log, const std::string& name,
                                        const std::string& words, bool quiet) {
  if (!words.empty()) log.say(compose("{}: warning: {}\n", name, words), quiet);
}

/// Says that the time step is not stable for soft contacts, on standard error. Collective.
template <class Scenario>
[[gnu::cold]] void mention_step(run_log& log, const std::string& name, world<Scenario>& w,
                                bool quiet) {
  if (w.steps() > 0) return;
  const std::string words = unstable_step(w, state_of(w).dt);
  if (w.rank() == 0 && !words.empty()) log.say(compose("{}: warning: {}\n", name, words), quiet);
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
void attach_checkpoints(world<Scenario>& w, const Options& options, run_log& log,
                        progress_line& progress, time_series& table, const bool& out_of_time) {
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
      const auto tell = [&log](const std::string& words) { log.say(words + "\n"); };
      plan.tell = tell;
      plan.restarted = [&](std::uint64_t step) {
        progress.begin_at(step);
        table.go_on_from(step, options.csv_every);
      };
      plan.out_of_time = &out_of_time;
      plan.configuration = options.configuration;
      plan.configured = [&options, tell](const std::string& theirs) {
        const std::string words = differing_options(options.configuration, theirs);
        if (!words.empty())
          tell(compose("goes on from {} with other options: {}", options.restart, words));
      };
      checkpoint_files<Scenario>::attach(w, plan);
    }
  }
}

/// The output that the options ask for. Collective. Returns what writes the state with which the
/// run ends, unless its step has a file already; empty without output.
template <class Scenario, class Options>
[[nodiscard]] std::function<void()> attach_output(world<Scenario>& w, const Options& options,
                                                  run_log& log) {
  if constexpr (Scenario::template has_feature<vtk_output>) {
    static_assert(complete<vtk_series<Scenario>>,
                  "run needs what writes the output of its scenario, which names "
                  "features<vtk_output>: write #include <talus/vtk.hpp>");
    if constexpr (complete<vtk_series<Scenario>>) {
      if (options.output.empty()) return {};
      const auto series = std::make_shared<vtk_series<Scenario>>(
          w, options.output, !options.restart.empty(),
          typename vtk_series<Scenario>::content{.surfaces = options.output_surfaces,
                                                 .force = options.force});
      if (w.rank() == 0 && series->replaces())
        log.say(compose("--output {} replaces a series of an earlier run\n", options.output),
                options.quiet);
      const auto due = [&w, every = options.output_every] { return w.steps() % every == 0; };
      const auto write = [series, due] {
        if (due()) series->write();
      };
      // The state with which the first run ended is none of a run without interruption.
      w.before_simulating("files of --output",
                          [series, due, write] { series->go_on(due()), write(); });
      w.monitor_each_step("files of --output", write);
      return [series] { series->write(); };
    }
  }
  return {};
}

/// Collective: the locks that the first rank of a job holds are those of this rank too, which
/// writes the results where it calls exit().
template <class Link>
void join_run(Link& link) {
  std::string text = lock_holder::this_process().text();
  byte_buffer bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  link.broadcast(bytes);
  text.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (link.rank() != 0) lock_holder::join(lock_holder::from_text(text));
}

/// One rank of the program: set-up, steps with progress, figures. Returns the exit code. `began`:
/// wall_seconds() when the program began.
template <class Scenario, class Options, class SetUp>
int run_rank(typename Scenario::transport::link& link, const Options& options,
             const std::string& name, SetUp& set_up, run_log& log, double began) {
  std::list<run_lock> locks;  // the last thing that the run gives up
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
  require_same_options(w, options.configuration);
  const std::string replaced = speaks ? inspect_outputs(options, locks) : "";
  run_configuration configuration;
  if (speaks) configuration.prepare(options, name);
  if (!options.json.empty()) join_run(link);
  // Ranks take part in what needs all of them if any speaks or keeps a log.
  const bool quiet = options.quiet, silent = quiet && options.log.empty();
  if (speaks) log.write(compose("ranks        {}\n", w.ranks()));

  progress_line progress(speaks && !quiet && !options.dry_run ? stderr : nullptr,
                         speaks && log.is_open()
                             ? [&log](const std::string& line) { log.write(line); }
                             : std::function<void(const std::string&)>());
  time_series table(options.csv, speaks, !options.restart.empty());
  run_place place{.rank = link.rank()};
  until_option until(options);
  std::vector<std::uint64_t> asked;  // of the calls of simulate()
  total_estimate estimate;
  call_trial<Scenario> trial;
  const auto end_trial = [&] {
    const run_estimate e = trial.estimate(w);
    if (speaks) log.print(to_text(e, estimate.calls == 0 ? name : ""));
    estimate.add(e);
    if (estimate.calls == most_tried_calls)
      throw ended_early{w.steps(), 0, ended_early::cause::dry_run};
    if (w.steps() < w.last_step()) w.stop();
  };
  step_times times;
  state_of(w).single_steps = &times;
  w.before_simulating("checks at the start", [&] {
    asked.push_back(w.last_step() - w.steps());
    if (options.dry_run) {
      trial.begin(w, estimate.steps);
      if (w.steps() == w.last_step()) end_trial();
      return;
    }
    require_pictures(w, options);
    mention_table(log, name, table.begin(w), quiet);
    configuration.write();
    until.begin(w, log);
    if (silent) return;
    mention_overlap(log, name, w, quiet);
    mention_friction(log, name, w, quiet);
    if constexpr (Scenario::contact_law::soft) mention_step(log, name, w, quiet);
  });
  std::string note, ended;
  bool out_of_time = false;
  time_limit limit(options.time_limit.empty() ? 0 : seconds_in(options.time_limit), began,
                   !options.checkpoint.empty());
  if (!options.csv.empty())
    w.monitor_after_observers("table of --csv", [&] {
      if (w.steps() % options.csv_every == 0) table.sample(w);
    });
  w.monitor_after_observers("progress line", [&] {
    if constexpr (has_monitors<Scenario>)
      if (!silent && (w.steps() % note_every == 0 || w.steps() == w.last_step())) {
        const function_clock clock(state_of(w), state_of(w).functions.number(name_of_monitors));
        note = measure_monitors(w).text;
      }
    progress.update(w.steps(), planned_steps(w, options), note);
    if (!limit.over(w, link) || w.stopped() || w.steps() >= planned_steps(w, options)) return;
    out_of_time = true;  // checkpoints end the run when they have written the state
    if (options.checkpoint.empty()) throw ended_early{w.steps(), 0, ended_early::cause::time_limit};
  });
  if (options.dry_run)
    w.monitor_after_observers("trial of --dry-run", [&] {
      if (trial.end_step(w)) end_trial();
    });
  attach_checkpoints(w, options, log, progress, table, out_of_time);
  const std::function<void()> write_last = attach_output(w, options, log);
  const auto view = attach_view(w, options, name);
  if (!replaced.empty()) log.say(replaced, quiet);
  const exit_guard guard(place, name, options, log);
  w.monitor_each_step("progress line", [&] {
    place.step = w.steps();
    if constexpr (requires { link.note_step(place.step); }) link.note_step(place.step);
  });
  const double cpu = thread_seconds();
  const double start = wall_seconds();
  results own;
  int code = 0;
  try {
    if constexpr (std::is_void_v<decltype(set_up(w, options))>)
      set_up(w, options);
    else
      own = set_up(w, options);
    w.require_restarted();
    if constexpr (Scenario::template has_feature<checkpoints>)
      if (const auto& hooks = checkpoint_access::keeper(w).hooks) hooks->finish();
  } catch (const ended_early& end) {
    if (end.why == ended_early::cause::dry_run) {
      if (speaks) log.print(to_text(estimate, "the calls after these are not tried"));
      return 0;
    }
    const bool by_limit = end.why == ended_early::cause::time_limit;
    if (speaks)
      log.say(compose("{}: ended by {} in step {}; {}\n", name,
                      by_limit               ? "--time-limit"
                      : end.signal == SIGINT ? "SIGINT"
                      : end.signal == SIGHUP ? "SIGHUP"
                                             : "SIGTERM",
                      end.step,
                      options.checkpoint.empty() ? "its state is lost: --checkpoint FILE keeps it"
                                                 : "go on with --restart " + options.checkpoint));
    if (!by_limit) return 128 + end.signal;  // as a shell says it
    code = exit_code_of_time_limit;
    ended = "time limit";
  } catch (const std::exception& e) {
    if (estimate.calls == 0 || w.ranks() > 1) throw;  // other ranks may wait
    if (speaks) log.print(to_text(estimate, compose("the program then ended with: {}", e.what())));
    return 0;
  } catch (const abi::__forced_unwind&) {  // the thread is cancelled
    throw;
  } catch (...) {
    rethrow_with_words(place);
  }
  if (options.dry_run) {
    if (estimate.calls == 0)
      throw usage_error(
          "--dry-run estimates in world.simulate(...), which this program never calls");
    if (speaks) log.print(to_text(estimate, ""));
    return 0;
  }
  require_pictures(w, options);
  progress.finish(w.steps(), note);
  const double wall = wall_seconds() - start;
  if (speaks && !silent) mention_forgotten(log, name, w.steps() > 0, options);
  if (speaks && ended.empty() && options.restart.empty()) {
    const auto given = [&](const char* name, bool differs) {
      return differs || on_command_line(options.configuration, name);
    };
    if (given("steps", options.steps != Options{}.steps))
      if (const std::string words = unused_steps(asked, options.steps); !words.empty())
        log.say(compose("{}: warning: {}\n", name, words), quiet);
    if (given("dt", options.dt != Options{}.dt))
      if (const std::string words = unused_dt(state_of(w).lengths.all(), options.dt);
          !words.empty())
        log.say(compose("{}: warning: {}\n", name, words), quiet);
  }

  if (w.steps() == 0) w.synchronize();
  if (write_last) write_last();
  if constexpr (!std::is_void_v<decltype(set_up(w, options))>)
    if (!silent) mention_results(log, name, link, own, quiet);
  table.sample(w);
  table.finish();
  if (view) view->finish();
  talus::summary figures = summarize(w, thread_seconds() - cpu, wall);
  figures.scenario = name;
  figures.ended = ended.empty() ? until.ended() : ended;
  figures.own = std::move(own);
  if (!speaks) return code;
  if (!silent) log.print(to_text(figures), quiet);
  configuration.write();
  if (!options.json.empty()) try {
      write_output(options.json, to_json(figures), results_output, options.force);
    } catch (const std::exception& e) {
      fail<std::runtime_error>("the results {} (--json) {}", options.json, e.what());
    }
  code = log.finish(code);
  log.write(compose("digest {}, {} s of wall time, exit code {}\n", figures.digest,
                    text(wall_seconds() - began, 6), code));
  return code;
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
int run_caught(int argc, char** argv, SetUp& set_up, const std::string& name, run_log& log) {
  // Before anything takes time: a signal in the first moments must not end the run either.
  constexpr bool listens = Scenario::template has_feature<checkpoints>;
  std::optional<listen_to_signals> listening;
  if constexpr (listens) listening.emplace();
  const bool speaks = find_launcher().rank == 0;
  const double began = wall_seconds();
  const auto complain = [&](const std::string& message) { log.say(name + ": " + message + "\n"); };
  try {
    Options chosen = parse<Options>(argc, argv, {}, "", withdraw_options<Scenario>);
    if (chosen.dry_run) write_nothing(chosen);
    if (chosen.checkpoint.empty() && listening) {
      listening.reset();
      if (const int signal = heard_signals().end; signal != 0) (void)::raise(signal);
    }
    if (speaks)
      log.open(chosen, argc, argv, program_build());
    else
      log.join(chosen.log);
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
      const int of_rank = run_rank<Scenario>(link, std::as_const(chosen), name, set_up, log, began);
      const bool job = find_launcher().size > 1;
      if (job) listening.reset();  // a launcher may end this process before MPI is at its end
      if (link.rank() == 0 || job) code = of_rank;
    });
    return code;
  } catch (const help_requested& help) {
    if (speaks) log.print(help.what());
    return 0;
  } catch (const unreadable_settings& error) {
    if (first_on_its_machine()) complain(error.what());
    return 2;
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

template <class Scenario, class Options, class SetUp>
int run_checked(int argc, char** argv, SetUp& set_up) {
  // A standard stream that is closed must not become an output: what it takes is lost, and said.
  for (const int id : {0, 1, 2})
    if (::fcntl(id, F_GETFD) < 0) (void)::open("/", O_RDONLY | O_DIRECTORY);
  // What takes no more is said like any other failure, and does not end the process.
  const ignored_signal size(SIGXFSZ), pipe(SIGPIPE);
  const locks_end_with_signals leaving;
  const std::string name = program_name(argc > 0 ? argv[0] : nullptr);
  run_log log(name);
  return log.finish(run_caught<Scenario, Options>(argc, argv, set_up, name, log));
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
