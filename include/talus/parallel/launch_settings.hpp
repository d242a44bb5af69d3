#pragma once
// Settings for starting the ranks of a program.
#include <cstdio>
#include <functional>
#include <string>

namespace talus {

struct launch_settings {
  /// The arguments of main(), for an MPI that has to be initialised; may be null.
  int* argc = nullptr;
  char*** argv = nullptr;
  /// Number of ranks requested by the user (--ranks); 0: not given.
  int ranks = 0;
  /// Number of ranks the decomposition was made for; 0: any.
  int default_ranks = 0;
  /// Seconds that a rank waits for others before a report names the rank that keeps them waiting
  /// and the reason; 0: never.
  double patience = 0;
  /// Further seconds after which the run ends, with exit code 1; 0: never.
  double give_up = 0;
  /// Receives the one message of a job whose ranks are processes and therefore cannot throw to
  /// a common caller. Writes to stderr by default.
  std::function<void(const std::string&)> report = [](const std::string& message) {
    std::fprintf(stderr, "%s\n", message.c_str());
    std::fflush(stderr);
  };
};

}  // namespace talus
