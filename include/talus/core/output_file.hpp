#pragma once
// Files that a run writes. An output replaces only a regular file of its own kind. It is written
// beside that file under a temporary name, and renamed when it is complete.
#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/id.hpp"

namespace talus::detail {

[[nodiscard, gnu::cold]] std::string system_words(int error = errno);

/// One kind of output.
struct output_kind {
  const char* name;                     ///< as in "is not ...": "a checkpoint of talus"
  bool (*owns)(std::string_view head);  ///< whether a file with these first bytes is of this kind
  bool forced = true;                   ///< whether the option --force applies to it
};
/// Bytes at the beginning of a file by which its kind is recognised.
inline constexpr std::size_t output_head_bytes = 4096;

/// The state of the path of an output.
struct output_target {
  bool replaces = false;    ///< a file of the same kind is there
  std::string objection{};  ///< why it must not be replaced, as the second half of a sentence
};

/// Whether a path names one of the program's own streams, in any form of it.
[[nodiscard, gnu::cold]] bool is_own_stream(const std::string& path);
/// Whether a path names a pipe or such a stream, which are written to and not replaced.
[[nodiscard, gnu::cold]] bool is_stream(const std::string& path);

[[nodiscard, gnu::cold]] std::string objection_to_link(const std::string& path,
                                                       const output_kind& kind, bool force);
[[nodiscard, gnu::cold]] output_target inspect_regular(const std::string& path,
                                                       const output_kind& kind, bool force);
/// Checks the path of an output. With `force` it may replace other regular files and symbolic
/// links, but never folders, devices, pipes, sockets, links that lead to one of these, and the
/// program's own streams, and never what another run writes.
[[nodiscard, gnu::cold]] output_target inspect_target(const std::string& path,
                                                      const output_kind& kind, bool force);

/// Why an output of `needs` more bytes cannot be written at this path, and what to do. For a full
/// disk it gives the number of missing bytes, or all of them if the disk does not report its free
/// space (quotas).
[[nodiscard, gnu::cold]] std::string words_of_failed_write(const std::string& path,
                                                           std::uint64_t needs, int error);

/// In its lifetime a signal does not end the process. A write beyond the limit of file sizes
/// (SIGXFSZ), or to a pipe that nobody reads (SIGPIPE), then fails like any other.
class ignored_signal {
 public:
  explicit ignored_signal(int signal) : signal_(signal), before_(std::signal(signal, SIG_IGN)) {}
  ignored_signal(const ignored_signal&) = delete;
  ignored_signal& operator=(const ignored_signal&) = delete;
  ~ignored_signal() {
    if (before_ != SIG_ERR) std::signal(signal_, before_);
  }

 private:
  int signal_;
  void (*before_)(int);
};

/// A temporary file beside an output. It gets the name of the output when it is complete, and is
/// removed otherwise. Where the file system can, it has no name before, so that nothing is left of
/// a process that is killed; otherwise it is PATH.part-, six random letters, and six that follow
/// from the name before them: no other file has such a name by chance.
class part_file {
 public:
  static constexpr std::string_view infix = ".part-";
  static constexpr std::size_t letters = 6;

  /// The last letters, for a name without its folder and them.
  [[nodiscard, gnu::cold]] static std::string seal(std::string_view name);

  part_file() = default;
  /// `named`: others open it by its name().
  [[gnu::cold]] explicit part_file(const std::string& path, bool named = false);
  part_file(const part_file&) = delete;
  part_file& operator=(const part_file&) = delete;
  part_file(part_file&& other) noexcept
      : name_(std::move(other.name_)),
        id_(std::exchange(other.id_, -1)),
        named_(std::exchange(other.named_, false)) {}
  part_file& operator=(part_file&& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(id_, other.id_);
    std::swap(named_, other.named_);
    return *this;
  }
  ~part_file();
  [[nodiscard]] bool good() const { return id_ >= 0; }
  [[nodiscard]] int id() const { return id_; }
  /// The name of the file, which need not be there yet.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Renames it to `path`. Returns false, with errno, on failure.
  [[nodiscard, gnu::cold]] bool rename_to(const std::string& path);
  /// Renames it to `path` and returns the open file. Returns -1, with errno, on failure.
  [[nodiscard, gnu::cold]] int rename_and_keep(const std::string& path);
  /// Names it `path` and returns the open file. Returns -1, with errno, on failure, and with EEXIST
  /// if something has that name: unlike renaming, this replaces nothing.
  [[nodiscard, gnu::cold]] int link_and_keep(const std::string& path);

 private:
  std::string name_;
  int id_ = -1;
  bool named_ = false;  ///< the name is there
};

/// Removes temporary files of this user, beside a file or, with an end, beside the files
/// PATH<digits>END. No other process may write one: see run_lock::remove_left_over.
[[gnu::cold]] void remove_parts_of(const std::string& path, std::string_view end = {});

/// Writes a whole text. Returns false, with errno, on failure.
[[nodiscard, gnu::cold]] bool write_text(int id, std::string_view text);

// The one way of opening, writing and finishing an output. All of these throw runtime_error, with
// the second half of a sentence.

/// Makes a file that holds a text so far, which replaces an existing one when it does. Returns the
/// open file, which grows at its end.
[[nodiscard, gnu::cold]] int make_output(const std::string& path, std::string_view text);
/// Makes a file that holds a text so far, or writes the text to a stream. Replaces an existing file
/// only if that is allowed, and leaves it unchanged on failure.
[[nodiscard, gnu::cold]] int begin_output(const std::string& path, std::string_view text,
                                          const output_kind& kind, bool force);
/// Throws runtime_error if an open file is no longer the one of that name: something else has
/// removed or replaced it, so that nobody would find what is written.
[[gnu::cold]] void require_own_output(int id, const std::string& path);
/// Adds a text to such a file by one write. Throws as require_own_output().
[[gnu::cold]] void add_to_output(int id, const std::string& path, std::string_view text);
/// Writes a whole output.
[[gnu::cold]] void write_output(const std::string& path, std::string_view text,
                                const output_kind& kind, bool force);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/core/output_file_definitions.hpp"
#endif
