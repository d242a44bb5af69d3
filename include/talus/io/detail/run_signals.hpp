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
[[nodiscard]] inline signals_heard& heard_signals() {
  static signals_heard all;
  return all;
}

/// In its lifetime SIGUSR1, SIGTERM and SIGINT (Ctrl-C) are counted instead of ending the process;
/// a second SIGTERM or SIGINT ends it as usual, for programs that take no steps.
class listen_to_signals {
 public:
  listen_to_signals() {
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
  listen_to_signals(const listen_to_signals&) = delete;
  listen_to_signals& operator=(const listen_to_signals&) = delete;
  ~listen_to_signals() {
    sigaction(SIGUSR1, &write_, nullptr);
    sigaction(SIGTERM, &end_, nullptr);
    sigaction(SIGINT, &interrupt_, nullptr);
  }

 private:
  struct sigaction write_ {
  }, end_{}, interrupt_{};
};

}  // namespace talus::detail
