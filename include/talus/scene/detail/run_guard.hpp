#pragma once
// What ends a run without its knowledge: exit() in a callback, and exceptions without words.
#include <cxxabi.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <string>
#include <typeinfo>

#include "talus/core/error.hpp"
#include "talus/parallel/launcher.hpp"

namespace talus::detail {

/// Where a rank is in its run. Trivial, as it is read while the program ends.
struct run_place {
  int rank = -1;
  std::uint64_t step = 0;  ///< the last that is complete
};
/// Of the rank on this thread; null elsewhere.
inline thread_local const run_place* place_of_this_thread = nullptr;

/// The run that this process is in.
struct run_under_way {
  std::mutex mutex;
  int ranks = 0;  ///< that are in their set-up or in a step
  pid_t process = 0;
  std::string name, json;
};
[[nodiscard]] run_under_way& current_run();

/// An exit handler. During a run it reports the exit and ends the process, and the job, with a code
/// that is not 0; otherwise it does nothing.
[[gnu::cold]] void refuse_exit(int code);

/// While it lives, on each rank, exit() is no way to end the process.
class exit_guard {
 public:
  exit_guard(const run_place& place, const std::string& name, const std::string& json);
  exit_guard(const exit_guard&) = delete;
  exit_guard& operator=(const exit_guard&) = delete;
  ~exit_guard();
};

/// In a handler of an exception that is no std::exception: throws one that says so.
[[noreturn, gnu::cold]] void rethrow_with_words(const run_place& place);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/detail/run_guard_definitions.hpp"
#endif
