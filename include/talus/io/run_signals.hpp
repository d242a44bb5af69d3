#pragma once
// The signals by which batch systems and users request the state of a run.
#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>

namespace talus::detail {

/// What was heard since listening began. A signal is of the process, and so is this.
struct signals_heard {
  std::atomic<unsigned> write{0};  ///< how often
  std::atomic<int> end{0};         ///< the last signal that asks for the end; 0: none
  static_assert(std::atomic<unsigned>::is_always_lock_free);
  static_assert(std::atomic<int>::is_always_lock_free);
};
[[nodiscard]] signals_heard& heard_signals();

/// In its lifetime SIGUSR1, SIGTERM, SIGINT (Ctrl-C) and SIGHUP are heard and do not end the
/// process. A second SIGTERM or SIGINT has its usual effect, for programs that take no steps; a
/// second SIGHUP has none, because a terminal that closes sends two. Under nohup SIGHUP stays
/// without effect.
class listen_to_signals {
 public:
  listen_to_signals();
  listen_to_signals(const listen_to_signals&) = delete;
  listen_to_signals& operator=(const listen_to_signals&) = delete;
  ~listen_to_signals();

 private:
  static constexpr std::array signals{SIGUSR1, SIGTERM, SIGINT, SIGHUP};
  std::array<struct sigaction, signals.size()> before_{};
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/run_signals_definitions.hpp"
#endif
