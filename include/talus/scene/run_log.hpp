#pragma once
// What a run says: on the terminal, and in the file of --log, whose lines survive a crash.
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "talus/core/run_lock.hpp"
#include "talus/scene/options.hpp"

namespace talus::detail {

/// The compiler of this program and what its predefined macros say of its flags.
[[nodiscard, gnu::cold]] inline std::string program_build() {
  std::string words =
#ifdef __clang__
      "clang " __clang_version__;
#elif defined(__GNUC__)
      "g++ " __VERSION__;
#else
      "another compiler";
#endif
#ifdef __OPTIMIZE__
  words += ", optimised";
#else
  words += ", not optimised";
#endif
#ifdef NDEBUG
  words += ", without assertions";
#else
  words += ", with assertions";
#endif
#ifdef __AVX512F__
  words += ", AVX-512";
#elif defined(__AVX2__)
  words += ", AVX2";
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  words += ", sanitizer";
#endif
  return words;
}

class run_log {
 public:
  explicit run_log(std::string program) : program_(std::move(program)) {}
  run_log(const run_log&) = delete;
  run_log& operator=(const run_log&) = delete;
  ~run_log();

  /// Begins the file with what the run is, or goes on with it at a restart. Throws runtime_error if
  /// the file cannot be written, or is not a log of talus.
  [[gnu::cold]] void open(const options& o, int argc, const char* const* argv,
                          const std::string& build);
  /// Makes this process add its messages to an existing file: for all processes but the first.
  void join(const std::string& file) { file_ = file; }
  [[nodiscard]] bool is_open() const { return id_ >= 0; }
  /// Into the file alone. Each call is one write, so that a crash loses no line. The run goes on
  /// without a line that cannot be written, says so, and does not end well: see finish().
  [[gnu::cold]] void write(std::string_view text);
  /// To standard error unless `quiet`, and into the file.
  [[gnu::cold]] void say(const std::string& text, bool quiet = false);
  /// Writes a text to standard output unless `quiet`, and into the file.
  [[gnu::cold]] void print(const std::string& text, bool quiet = false);
  /// The exit code: 1 instead of 0 if a line of the log, or anything for standard output, is lost.
  [[nodiscard, gnu::cold]] int finish(int code);

 private:
  /// Says, the first time, that the file cannot be written.
  [[gnu::cold]] void lose_line(int error);
  /// Says, the first time, that standard output cannot be written.
  [[gnu::cold]] void lose_print(int error);

  std::string program_, name_{};
  std::optional<run_lock> lock_{};
  int id_ = -1;
  std::string file_{};  ///< of join(), until it is open
  bool line_lost_ = false, print_lost_ = false;
  std::mutex mutex_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/run_log_definitions.hpp"
#endif
