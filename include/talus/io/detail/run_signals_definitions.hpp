#pragma once
// The definitions of run_signals.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/run_signals.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE signals_heard& heard_signals() {
  static signals_heard all;
  return all;
}

TALUS_HDF5_INLINE listen_to_signals::listen_to_signals() {
  (void)heard_signals();
  struct sigaction action {};
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  action.sa_handler = [](int) { ++heard_signals().write; };
  sigaction(SIGUSR1, &action, &write_);
  action.sa_handler = [](int) { ++heard_signals().end; };
  action.sa_flags |= static_cast<int>(SA_RESETHAND);
  sigaction(SIGTERM, &action, &end_);
  action.sa_handler = [](int) { ++heard_signals().interrupt; };
  sigaction(SIGINT, &action, &interrupt_);
}

TALUS_HDF5_INLINE listen_to_signals::~listen_to_signals() {
  sigaction(SIGUSR1, &write_, nullptr);
  sigaction(SIGTERM, &end_, nullptr);
  sigaction(SIGINT, &interrupt_, nullptr);
}

}  // namespace talus::detail
