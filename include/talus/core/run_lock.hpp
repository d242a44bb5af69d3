#pragma once
// A file is written by one run at a time. FILE.lock beside it names the run. The kernel holds the
// lock for that process and releases it when the process ends, in any way; so the file of a killed
// run blocks no other run.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <string>
#include <string_view>

#include "talus/core/error.hpp"
#include "talus/core/lock_holder.hpp"
#include "talus/core/output_file.hpp"

namespace talus::detail {

/// Such a lock during its lifetime. The rank of a run that renames the files holds it.
class run_lock {
 public:
  /// Removes what killed runs have left beside the file. Throws runtime_error, with `output` as the
  /// subject ("the checkpoint a.h5"), if another run holds the lock or none can be made.
  [[gnu::cold]] run_lock(const std::string& file, const std::string& output);
  run_lock(const run_lock&) = delete;
  run_lock& operator=(const run_lock&) = delete;
  ~run_lock();
  /// Removes temporary files that killed runs have left beside another file of this output, or with
  /// an end beside the files FILE<digits>END; none where the file system has no locks, because runs
  /// of other machines may still write them.
  [[gnu::cold]] void remove_left_over(const std::string& file, std::string_view end = {}) const;
  /// Removes the files of all locks of this process, which then ends at once, without destructors.
  /// A handler of signals may call it after prepare_to_leave().
  [[gnu::cold]] static void leave_all();
  [[gnu::cold]] static void prepare_to_leave();
  /// Whether this is the lock of that file, for any form of its path.
  [[nodiscard, gnu::cold]] bool is_of(const std::string& file) const;

 private:
  [[gnu::cold]] void take(const std::string& file);
  /// Opens the file of the lock, or makes it.
  [[gnu::cold]] void open(const std::string& file);
  /// Makes it, with its text, and locked: no other run sees an empty one. Returns false, with
  /// errno, if it is there or cannot be made.
  [[nodiscard, gnu::cold]] bool make(const std::string& file);
  void close();
  void remove_file() const;
  [[nodiscard, gnu::cold]] bool is_named() const;
  [[noreturn, gnu::cold]] void refuse();

  /// The locks of this process, as far as there is room; those beyond go with the next run. A lock
  /// that is destroyed after leave_all() began waits there for the end.
  struct locks_held {
    std::array<std::atomic<run_lock*>, 64> locks{};
    std::atomic<bool> leaving = false;
    static_assert(std::atomic<run_lock*>::is_always_lock_free);
  };
  [[nodiscard]] static locks_held& all_held();

  std::string name_;
  int id_ = -1;
  pid_t process_ = ::getpid();  ///< that holds it; a fork leaves the file to it
  bool locked_ = false;         ///< by the file system, not by the text of the file alone
  bool owns_file_ = false;      ///< FILE.lock was made by a run
};

/// In its lifetime signals that end the process remove the files of its locks before.
class locks_end_with_signals {
 public:
  locks_end_with_signals();
  locks_end_with_signals(const locks_end_with_signals&) = delete;
  locks_end_with_signals& operator=(const locks_end_with_signals&) = delete;
  ~locks_end_with_signals();

 private:
  static constexpr std::array signals{SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGXCPU};
  std::array<struct sigaction, signals.size()> before_{};
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/core/run_lock_definitions.hpp"
#endif
