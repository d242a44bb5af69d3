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
[[nodiscard]] inline run_under_way& current_run() {
  static run_under_way* const all = new run_under_way;  // outlives every exit handler
  return *all;
}

/// An exit handler. During a run it reports the exit and ends the process, and the job, with a code
/// that is not 0; otherwise it does nothing.
[[gnu::cold]] inline void refuse_exit(int code) {
  run_under_way& run = current_run();
  const std::lock_guard lock(run.mutex);
  if (run.ranks == 0 || run.process != ::getpid()) return;
  const run_place* place = place_of_this_thread;
  const std::string where = place == nullptr
                                ? std::string("on a thread that is no rank")
                                : compose("on rank {} after step {}", place->rank, place->step);
  std::fflush(nullptr);
  std::fputs(compose("{}: ended early: the program called exit({}) {}, and the run was not at its "
                     "end; throw an exception or return from the set-up to end a run\n",
                     run.name, code, where)
                 .c_str(),
             stderr);
  if (!run.json.empty()) {
    std::ofstream file(run.json);
    file << compose("{0}\n  \"ended_early\": \"exit({2}) {3}\"\n{1}\n", '{', '}', code, where);
  }
  std::fflush(nullptr);
  const int error = (code & 0xff) != 0 ? code & 0xff : EXIT_FAILURE;
  if (const auto end = end_of_job.load()) end(error);
  std::_Exit(error);
}

/// While it lives, on each rank, exit() is no way to end the process.
class exit_guard {
 public:
  exit_guard(const run_place& place, const std::string& name, const std::string& json) {
    static std::once_flag once;
    std::call_once(once, [] {
#ifdef __GLIBC__
      ::on_exit([](int code, void*) { refuse_exit(code); }, nullptr);
#else
      std::atexit([] { refuse_exit(0); });
#endif
      std::at_quick_exit([] { refuse_exit(0); });
    });
    place_of_this_thread = &place;
    run_under_way& run = current_run();
    const std::lock_guard lock(run.mutex);
    ++run.ranks;
    run.process = ::getpid();
    run.name = name, run.json = json;
  }
  exit_guard(const exit_guard&) = delete;
  exit_guard& operator=(const exit_guard&) = delete;
  ~exit_guard() {
    place_of_this_thread = nullptr;
    run_under_way& run = current_run();
    const std::lock_guard lock(run.mutex);
    --run.ranks;
  }
};

/// In a handler of an exception that is no std::exception: throws one that says so.
[[noreturn, gnu::cold]] inline void rethrow_with_words(const run_place& place) {
  std::string type = "unknown";
  if (const std::type_info* found = abi::__cxa_current_exception_type()) {
    int status = 0;
    char* name = abi::__cxa_demangle(found->name(), nullptr, nullptr, &status);
    type = status == 0 && name != nullptr ? name : found->name();
    std::free(name);
  }
  fail<std::runtime_error>(
      "the program threw an exception of type {} on rank {} after step {}, which is no "
      "std::exception and says nothing: throw std::runtime_error with what is wrong",
      type, place.rank, place.step);
}

}  // namespace talus::detail
