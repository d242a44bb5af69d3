#pragma once
// Guards against exit() in a callback and exceptions without a message, which would end a run
// silently.
#include <cxxabi.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <typeinfo>

#include "talus/core/error.hpp"
#include "talus/parallel/launcher.hpp"
#include "talus/scene/run_log.hpp"

namespace talus::detail {

/// The progress of a rank in its run. Trivial, because it is read while the program ends.
struct run_place {
  int rank = -1;
  std::uint64_t step = 0;  ///< the last that is complete
};
/// The progress of the rank that runs on this thread; null on other threads.
inline thread_local const run_place* place_of_this_thread = nullptr;

/// The run that this process is in.
struct run_under_way {
  std::mutex mutex;
  int ranks = 0;  ///< that are in their set-up or in a step
  pid_t process = 0;
  std::string name, json;
  bool force = false;
  run_log* log = nullptr;
};
[[nodiscard]] run_under_way& current_run();

/// To standard error unless `quiet`, and into the log of the run that this process is in.
[[gnu::cold]] void say_in_run(const std::string& text, bool quiet = false);

/// An exit handler. During a run it reports the exit and ends the process, and the job, with a code
/// that is not 0; otherwise it does nothing.
[[gnu::cold]] void refuse_exit(int code);

/// During its lifetime on each rank, exit() ends the process with an error.
class exit_guard {
 public:
  exit_guard(const run_place& place, const std::string& name, const options& options, run_log& log);
  exit_guard(const exit_guard&) = delete;
  exit_guard& operator=(const exit_guard&) = delete;
  ~exit_guard();
};

/// In the handler of an exception that is not a std::exception: throws one that reports it.
[[noreturn, gnu::cold]] void rethrow_with_words(const run_place& place);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/detail/run_guard_definitions.hpp"
#endif
