#pragma once
// FILE.lock names the run that writes FILE. See run_lock.hpp.
#include <string>
#include <string_view>

namespace talus::detail {

/// The holder of a lock, as recorded in the file.
struct lock_holder {
  static constexpr std::string_view mark = "talus run lock\n";

  std::string host, pid, since;
  std::string started;  ///< of the process, in ticks since boot; distinguishes a reused pid

  [[nodiscard, gnu::cold]] static lock_holder this_process();
  [[nodiscard, gnu::cold]] static lock_holder from_text(const std::string& text);
  [[nodiscard, gnu::cold]] std::string text() const;
  [[nodiscard, gnu::cold]] std::string words() const;
  /// Whether it is a process of this machine that still runs.
  [[nodiscard, gnu::cold]] bool lives_here() const;
  /// Whether it is this process, or the one of join().
  [[nodiscard, gnu::cold]] bool is_of_this_run() const;
  /// Another process of the same run, which holds the locks: the first rank of a job.
  [[gnu::cold]] static void join(const lock_holder& of_run);

 private:
  [[nodiscard, gnu::cold]] bool operator==(const lock_holder& x) const {
    return host == x.host && pid == x.pid && started == x.started;
  }
  [[nodiscard, gnu::cold]] static lock_holder& joined();
  /// The value of the line that begins with `key`.
  [[nodiscard, gnu::cold]] static std::string line(const std::string& text, const char* key);
  /// The 22nd field of /proc/PID/stat; the second may hold blanks and ends with the last ')'.
  [[nodiscard, gnu::cold]] static std::string start_of(const std::string& pid);
};

/// The content of the open file of a lock.
[[nodiscard, gnu::cold]] std::string text_of_lock(int id);
/// Says that a run writes a file, and what to do: the second half of a sentence.
[[nodiscard, gnu::cold]] std::string words_of_other_run(const lock_holder& holder);
/// Why a file must not be written while another run writes it, or the series to which it belongs:
/// the second half of a sentence. Empty if none does. (A lock without a text, of a full disk, is
/// not seen.)
[[nodiscard, gnu::cold]] std::string objection_of_other_run(const std::string& path);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/core/lock_holder_definitions.hpp"
#endif
