#pragma once
// The definitions of run_signals.hpp, in the compiled part or in each program.
#include "talus/core/linkage.hpp"
#include "talus/io/run_signals.hpp"

namespace talus::detail {

TALUS_INLINE signals_heard& heard_signals() {
  static signals_heard all;
  return all;
}

TALUS_INLINE listen_to_signals::listen_to_signals() {
  heard_signals().write = 0;
  heard_signals().end = 0;
  for (std::size_t k = 0; k < signals.size(); ++k) {
    struct sigaction action {};
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    if (signals[k] == SIGUSR1) {
      action.sa_handler = [](int) { ++heard_signals().write; };
    } else {
      action.sa_handler = [](int signal) { heard_signals().end = signal; };
      if (signals[k] != SIGHUP) action.sa_flags |= static_cast<int>(SA_RESETHAND);
    }
    sigaction(signals[k], &action, &before_[k]);
    if (signals[k] == SIGHUP && before_[k].sa_handler == SIG_IGN)
      sigaction(signals[k], &before_[k], nullptr);
  }
}

TALUS_INLINE listen_to_signals::~listen_to_signals() {
  for (std::size_t k = 0; k < signals.size(); ++k) sigaction(signals[k], &before_[k], nullptr);
}

}  // namespace talus::detail
