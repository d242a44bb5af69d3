#pragma once
// features<checkpoints>: its part of a world. io/ writes and reads files, and a program includes it
// by <talus/checkpoint.hpp>; this file holds the state that the user adds, and the points of
// simulate() at which files are written or read.
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/exact_sum.hpp"
#include "talus/core/math.hpp"
#include "talus/state/course.hpp"
#include "talus/world/run_parameters.hpp"

namespace talus {

/// Arguments of simulate().
struct simulation {
  std::size_t steps = 0;  ///< number of time steps; after a restart, earlier ones count
  real dt = 0;            ///< length of a step, in units of time
  /// Ends this call early: evaluated on all ranks after each step; the call ends if it holds on
  /// any. A checkpoint records the end.
  std::function<bool()> stop_when{};
  std::uint64_t check_every = 1;  ///< steps of the world between evaluations
};

namespace detail {

/// Changes to a call of simulate() when a run continues from a file.
struct restart_plan {
  std::size_t steps = 0;  ///< to be made
  bool skips = false;     ///< all of them were made before the file was written
  bool restarts = false;  ///< the state is now the state of the file
  bool stopped = false;   ///< stop() or a condition ended this call
};

/// Functions that simulate() calls if checkpoints are in use. All functions are collective.
struct checkpoint_hooks {
  checkpoint_hooks() = default;
  checkpoint_hooks(const checkpoint_hooks&) = delete;
  checkpoint_hooks& operator=(const checkpoint_hooks&) = delete;
  virtual ~checkpoint_hooks() = default;
  virtual restart_plan begin(const simulation& s) = 0;
  virtual void before_step() = 0;
  virtual void after_step() = 0;
  /// `ends`: this call of simulate() makes no further step.
  virtual void after_observers(bool ends) = 0;
  /// A call of simulate() that made steps, or went on from a file, ends.
  virtual void end_call() = 0;
  /// After the last call of simulate(): writes the state, unless its file is of this step.
  virtual void finish() = 0;
  /// Whether the run writes its state to that file. On rank 0 alone.
  [[nodiscard]] virtual bool writes(const std::string& file) const = 0;
  /// Throws runtime_error if simulate() has not reached the step of the file.
  virtual void require_restarted() const = 0;
  /// Throws if a step is made by hand among those that a restart skips.
  virtual void refuse_step_before_restart() const = 0;
  /// Throws runtime_error: bodies are read, by the function named `what`, after calls of simulate()
  /// that a restart skips.
  virtual void refuse_reading(const std::string& what) const = 0;
};

/// User-defined state: the bytes of a value, or a number that is summed over the ranks.
struct kept_value {
  enum class kind : std::uint8_t { alike, sum_of_reals, sum_of_integers, exact_sum };
  std::string name;
  kind means;
  std::size_t bytes;
  void* at;
  double (*real_number)(const void*) = nullptr;
  std::uint64_t (*integer)(const void*) = nullptr;
  void (*set_real)(void*, double) = nullptr;
  void (*set_integer)(void*, std::uint64_t) = nullptr;

  /// The bytes of the value in a file.
  [[nodiscard]] std::size_t stored_bytes() const {
    return means == kind::alike       ? bytes
           : means == kind::exact_sum ? (exact_sum::digits + 1) * sizeof(double)
                                      : sizeof(double);
  }
};

/// What world.once() has computed, or done: the bytes of its value, and the counters of added
/// bodies after it.
struct once_value {
  std::string name;
  byte_buffer bytes{};
  std::uint64_t fills = 0, attempts = 0;
  bool named = false;  ///< by this run; else it comes from a file
};

struct checkpoint_keeper {
  std::vector<kept_value> values, meters;
  std::vector<std::uint64_t> added_elsewhere;  ///< by ranks of an earlier run
  std::vector<once_value> once;
  std::optional<parameters> given;          ///< by the program, so far
  parameters after_call{};                  ///< at the end of the last call of simulate()
  std::uint64_t restarted_at = 0;           ///< step of the file that was read
  std::string configuration;                ///< of the run, alike on all ranks
  std::unique_ptr<checkpoint_hooks> hooks;  ///< null if no file is requested
  detail::course course;                    ///< the calls of simulate()
  /// The bytes of `values` after each call of simulate() that has ended. On rank 0 with all sums.
  std::vector<byte_buffer> kept_after_calls;
  /// Calls of simulate() that a restart has skipped so far: the bodies are those of the set-up.
  std::uint64_t skipped = 0;

  /// At the start of a call of simulate(): what the program has changed since the last one. (What
  /// an observer changes is not given by the program: a restart takes it from the file.)
  void note_given(const parameters& now) {
    if (!given) given = after_call = now;
    for (std::size_t k = 0; k < now.size(); ++k)
      if (now[k] != after_call[k]) (*given)[k] = now[k];
  }
  /// The value of that name in a file, or null. Throws invalid_argument if this run has named it
  /// before, and runtime_error if a restart misses it.
  [[nodiscard, gnu::cold]] const once_value* find_once(const std::string& name) {
    if (name.empty() || name.find('\n') != name.npos)
      fail<std::invalid_argument>(
          "world.once needs a name in one line, by which the value is found again");
    for (once_value& v : once)
      if (v.name == name) {
        if (std::exchange(v.named, true))
          fail<std::invalid_argument>(
              "world.once has been given the name '{}' twice: name each value once, in a loop with "
              "its number",
              name);
        return &v;
      }
    if (skipped > 0)
      hooks->refuse_reading(
          compose("world.once(\"{}\", f), of which the file has no value,", name));
    return nullptr;
  }

  template <class T>
  void add(const std::string& name, T& value) {
    static_assert(plain_bytes<T> && std::is_copy_constructible_v<T>,
                  "world.keep takes a value that owns no memory, such as a number or a "
                  "random_stream: keep its parts one by one");
    require_new(name);
    values.push_back({name, kept_value::kind::alike, sizeof(T), &value});
  }
  void add_sum(const std::string& name, exact_sum& value) {
    require_new(name);
    values.push_back(sum_of(name, value));
  }
  template <class T>
  void add_sum(const std::string& name, T& value) {
    static_assert(std::floating_point<T> || (std::integral<T> && !std::same_as<T, bool>),
                  "world.keep_sum takes a number: for anything else there is world.keep");
    require_new(name);
    values.push_back(sum_of(name, value));
  }
  /// A sum over the ranks and the steps since this call, of a monitor that the program has made. A
  /// file that has no sum of this name leaves it as it is.
  template <class T>
  void add_meter(std::string name, T& value) {
    const auto taken = [&](const kept_value& v) { return v.name == name; };
    while (std::any_of(meters.begin(), meters.end(), taken)) name += '+';
    meters.push_back(sum_of(name, value));
  }

 private:
  [[nodiscard, gnu::cold]] static kept_value sum_of(const std::string& name, exact_sum& value) {
    return {name, kept_value::kind::exact_sum, sizeof(value), &value};
  }
  template <class T>
  [[nodiscard, gnu::cold]] static kept_value sum_of(const std::string& name, T& value) {
    kept_value k{name, {}, sizeof(T), &value};
    if constexpr (std::floating_point<T>) {
      k.means = kept_value::kind::sum_of_reals;
      k.real_number = [](const void* at) {
        return static_cast<double>(*static_cast<const T*>(at));
      };
      k.set_real = [](void* at, double x) { *static_cast<T*>(at) = static_cast<T>(x); };
    } else {
      k.means = kept_value::kind::sum_of_integers;
      k.integer = [](const void* at) {
        return static_cast<std::uint64_t>(*static_cast<const T*>(at));
      };
      k.set_integer = [](void* at, std::uint64_t x) { *static_cast<T*>(at) = static_cast<T>(x); };
    }
    return k;
  }
  [[gnu::cold]] void require_new(const std::string& name) const {
    if (name.empty() || name.find('\n') != name.npos)
      fail<std::invalid_argument>(
          "world.keep needs a name in one line, by which the value is found again");
    for (const kept_value& v : values)
      if (v.name == name)
        fail<std::invalid_argument>(
            "world.keep has been given two values of the name '{}': name each once", name);
  }
};
struct keeps_nothing {};

/// The checkpoint files of a run.
struct checkpoint_plan {
  std::string to;          ///< file to write; empty: none
  std::size_t every = 0;   ///< steps between checkpoints; 0: on signals and at the end
  std::uint64_t last = 0;  ///< the step after which the run ends, if known
  std::string from;        ///< file to continue from; empty: none
  bool force = false;      ///< also replaces a file that is not a checkpoint
  bool quiet = false;      ///< no message when it replaces a checkpoint
  std::function<void(const std::string&)> tell;    ///< takes a message for the user, on rank 0
  std::function<void(std::uint64_t)> restarted{};  ///< takes the step of the file, when it is read
  std::string configuration{};  ///< of the run, to be written; alike on all ranks
  /// takes the configuration of the run that wrote the file, on rank 0, when it is read
  std::function<void(const std::string&)> configured{};
  /// whether the time limit ends the run with this step; alike on all ranks
  const bool* out_of_time = nullptr;
};

/// Thrown, alike on all ranks, to end a run before its last step: after a signal to end (SIGTERM,
/// SIGHUP, or SIGINT by Ctrl-C) or at the time limit, when the state is written, and by a dry run.
struct ended_early {
  enum class cause { signal, time_limit, dry_run };
  std::uint64_t step = 0;
  int signal = 0;
  cause why = cause::signal;
};

/// The parts of a world that io/ may use.
struct checkpoint_access;

/// The files of a run; defined by <talus/checkpoint.hpp>.
template <class Scenario>
class checkpoint_files;

}  // namespace detail
}  // namespace talus
