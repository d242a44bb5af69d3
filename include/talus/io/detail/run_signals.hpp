#pragma once
// The signals by which batch systems and users request the state of a run.
#include <atomic>
#include <csignal>

namespace talus::detail {

/// How often each was received since the program began. A signal is of the process, and so is this.
struct signals_heard {
  std::atomic<unsigned> write{0}, end{0}, interrupt{0};
  static_assert(std::atomic<unsigned>::is_always_lock_free);
};
[[nodiscard]] signals_heard& heard_signals();

/// In its lifetime SIGUSR1, SIGTERM and SIGINT (Ctrl-C) are counted instead of ending the process;
/// a second SIGTERM or SIGINT ends it as usual, for programs that take no steps.
class listen_to_signals {
 public:
  listen_to_signals();
  listen_to_signals(const listen_to_signals&) = delete;
  listen_to_signals& operator=(const listen_to_signals&) = delete;
  ~listen_to_signals();

 private:
  struct sigaction write_ {
  }, end_{}, interrupt_{};
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/run_signals_definitions.hpp"
#endif
