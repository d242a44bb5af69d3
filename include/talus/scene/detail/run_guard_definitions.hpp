#pragma once
// The definitions of run_guard.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/core/output_file.hpp"
#include "talus/core/run_lock.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/io/output_kinds.hpp"
#include "talus/scene/detail/run_guard.hpp"

namespace talus::detail {

TALUS_INLINE run_under_way& current_run() {
  static run_under_way* const all = new run_under_way;  // outlives every exit handler
  return *all;
}

TALUS_INLINE void say_in_run(const std::string& text, bool quiet) {
  run_under_way& run = current_run();
  const std::lock_guard lock(run.mutex);
  if (run.ranks > 0 && run.log != nullptr)
    run.log->say(text, quiet);
  else if (!quiet)
    std::fputs(printable(text).c_str(), stderr);
}

TALUS_INLINE void refuse_exit(int code) {
  run_under_way& run = current_run();
  const std::lock_guard lock(run.mutex);
  if (run.ranks == 0 || run.process != ::getpid()) return;
  const run_place* place = place_of_this_thread;
  const std::string where = place == nullptr
                                ? std::string("on a thread that is no rank")
                                : compose("on rank {} after step {}", place->rank, place->step);
  std::fflush(nullptr);
  const std::string words = compose(
      "{}: ended early: the program called exit({}) {}, and the run was not at its end; "
      "throw an exception or return from the set-up to end a run\n",
      run.name, code, where);
  if (run.log != nullptr)
    run.log->say(words);
  else
    std::fputs(printable(words).c_str(), stderr);
  if (!run.json.empty()) try {
      write_output(
          run.json,
          compose("{0}\n  \"ended_early\": \"exit({2}) {3}\"\n{1}\n", '{', '}', code, where),
          results_output, run.force);
    } catch (const std::exception&) {  // the exit is said
    }
  std::fflush(nullptr);
  const int error = (code & 0xff) != 0 ? code & 0xff : EXIT_FAILURE;
  run_lock::leave_all();
  if (const auto end = end_of_job.load()) end(error);
  std::_Exit(error);
}

TALUS_INLINE exit_guard::exit_guard(const run_place& place, const std::string& name,
                                    const options& options, run_log& log) {
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
  if (run.process != ::getpid()) run.ranks = 0;  // those of the process that has forked
  ++run.ranks;
  run.process = ::getpid();
  run.name = name, run.json = options.json, run.force = options.force, run.log = &log;
}

TALUS_INLINE exit_guard::~exit_guard() {
  place_of_this_thread = nullptr;
  run_under_way& run = current_run();
  const std::lock_guard lock(run.mutex);
  if (--run.ranks == 0) run.log = nullptr;
}

TALUS_INLINE void rethrow_with_words(const run_place& place) {
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
