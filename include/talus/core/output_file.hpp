#pragma once
// Files that a run writes. An output replaces a regular file of its own kind, never anything else;
// it is written beside that file under a name of its own, and renamed when it is whole.
#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
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

[[nodiscard, gnu::cold]] inline std::string system_words(int error = errno) {
  return std::strerror(error);
}

/// One kind of output.
struct output_kind {
  const char* name;                     ///< as in "is not ...": "a checkpoint of talus"
  bool (*owns)(std::string_view head);  ///< whether a file with these first bytes is of this kind
};
/// Bytes at the beginning of a file by which its kind is recognised.
inline constexpr std::size_t output_head_bytes = 4096;

/// What an output finds at its path.
struct output_target {
  bool replaces = false;    ///< a file of the same kind is there
  std::string objection{};  ///< why it must not be replaced, as the second half of a sentence
};

/// Whether a path names a pipe or one of the program's own streams, into which text is written and
/// which is not replaced.
[[nodiscard, gnu::cold]] inline bool is_stream(const std::string& path) {
  for (const std::string_view own : {"/dev/stdout", "/dev/stderr", "/dev/fd/", "/proc/self/fd/"})
    if (path.starts_with(own)) return true;
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 && S_ISFIFO(found.st_mode);
}

[[nodiscard, gnu::cold]] inline std::string objection_to_link(const std::string& path, bool force) {
  if (force) return {};
  std::string to(4096, '\0');
  const ssize_t length = ::readlink(path.c_str(), to.data(), to.size());
  to.resize(length > 0 ? static_cast<std::size_t>(length) : 0);
  return compose(
      "is a symbolic link to {}: name the file itself, or add --force, which replaces the link and "
      "leaves what it leads to",
      to);
}
[[nodiscard, gnu::cold]] inline output_target inspect_regular(const std::string& path,
                                                              const output_kind& kind, bool force) {
  const int id = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  std::string head(output_head_bytes, '\0');
  const ssize_t length = id >= 0 ? ::read(id, head.data(), head.size()) : -1;
  const int error = errno;
  if (id >= 0) ::close(id);
  if (length >= 0) {
    head.resize(static_cast<std::size_t>(length));
    if (head.empty()) return {};  // nothing to lose
    if (kind.owns(head)) return {.replaces = true};
  }
  if (force) return {};
  if (length < 0)
    return {.objection = compose("is there already and cannot be read ({}): name another file, or "
                                 "add --force to replace it",
                                 system_words(error))};
  return {.objection = compose("is there already and is not {}: name another file, remove this "
                               "one, or add --force to replace it",
                               kind.name)};
}
/// Looks at what lies at the path of an output. With `force` other regular files and symbolic links
/// may be replaced; folders and devices never.
[[nodiscard, gnu::cold]] inline output_target inspect_target(const std::string& path,
                                                             const output_kind& kind, bool force) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) return {};  // absent, or found out when it is opened
  if (S_ISREG(found.st_mode)) return inspect_regular(path, kind, force);
  if (S_ISLNK(found.st_mode)) return {.objection = objection_to_link(path, force)};
  if (S_ISDIR(found.st_mode)) return {.objection = "is a folder: name a file in it"};
  return {.objection =
              "is a device, a pipe or a socket, which this output must not replace: name "
              "a file"};
}

/// "no room ..." for an output of `needs` bytes more at this path. What is missing is what the disk
/// lacks; where the disk does not say so (quotas), all of it.
[[nodiscard, gnu::cold]] inline std::string words_of_missing_room(const std::string& path,
                                                                  std::uint64_t needs, int error) {
  std::uint64_t missing = needs;
  struct statvfs disk {};
  if (::statvfs(path.c_str(), &disk) == 0) {
    const std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
    if (free < needs) missing = needs - free;
  }
  return compose(
      "there is no room for {} bytes more ({}), {} bytes are missing: make room, or name a file on "
      "another disk",
      needs, system_words(error), missing);
}

/// A new file beside an output, which gets the name of the output when it is whole, and is removed
/// otherwise. Its name is its own: PATH.part- and six letters.
class part_file {
 public:
  static constexpr std::string_view infix = ".part-";
  static constexpr std::size_t letters = 6;

  part_file() = default;
  [[gnu::cold]] explicit part_file(const std::string& path) {
    static constexpr std::string_view alphabet = "abcdefghijklmnopqrstuvwxyz0123456789";
    for (int attempt = 0; attempt < 100; ++attempt) {
      std::uint64_t random = mix(
          static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count()) ^
          static_cast<std::uint64_t>(::getpid()) << 40 ^ reinterpret_cast<std::uintptr_t>(this));
      name_ = path + std::string(infix);
      for (std::size_t k = 0; k < letters; ++k, random /= alphabet.size())
        name_ += alphabet[random % alphabet.size()];
      id_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
      if (id_ >= 0 || errno != EEXIST) return;
    }
  }
  part_file(const part_file&) = delete;
  part_file& operator=(const part_file&) = delete;
  part_file(part_file&& other) noexcept
      : name_(std::move(other.name_)), id_(std::exchange(other.id_, -1)) {}
  part_file& operator=(part_file&& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(id_, other.id_);
    return *this;
  }
  ~part_file() {
    if (id_ < 0) return;
    ::close(id_);
    ::unlink(name_.c_str());
  }
  [[nodiscard]] bool good() const { return id_ >= 0; }
  [[nodiscard]] int id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Gives it the name `path`. False, with errno, where that fails.
  [[nodiscard, gnu::cold]] bool rename_to(const std::string& path) {
    if (::rename(name_.c_str(), path.c_str()) != 0) return false;
    ::close(std::exchange(id_, -1));
    return true;
  }
  /// The same, and hands over the open file.
  [[nodiscard, gnu::cold]] int rename_and_keep(const std::string& path) {
    if (::rename(name_.c_str(), path.c_str()) != 0) return -1;
    return std::exchange(id_, -1);
  }

 private:
  std::string name_;
  int id_ = -1;
};

/// Removes what killed runs have left of such files. Only for who holds the lock of the output.
[[gnu::cold]] inline void remove_parts_of(const std::string& path) {
  const auto slash = path.find_last_of('/');
  const std::string folder = slash == path.npos ? "." : path.substr(0, slash + 1);
  const std::string begin = path.substr(slash + 1) + std::string(part_file::infix);
  DIR* const all = ::opendir(folder.c_str());
  if (all == nullptr) return;
  while (const dirent* const one = ::readdir(all)) {
    const std::string_view name = one->d_name;
    if (name.starts_with(begin) && name.size() == begin.size() + part_file::letters)
      ::unlinkat(::dirfd(all), one->d_name, 0);
  }
  ::closedir(all);
}

/// Writes all of a text. False, with errno, where that fails.
[[nodiscard, gnu::cold]] inline bool write_text(int id, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(id, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      if (n == 0) errno = ENOSPC;
      return false;
    }
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}
/// Replaces a file by a text, or writes it to a stream. Throws runtime_error, the second half of a
/// sentence, where that fails or something else is there; a file is as it was then.
[[gnu::cold]] inline void write_output(const std::string& path, std::string_view text,
                                       const output_kind& kind, bool force) {
  const auto fail_to_write = [&](std::size_t needs) {
    const int error = errno;
    if (error == ENOSPC || error == EDQUOT)
      fail<std::runtime_error>("cannot be written: {}", words_of_missing_room(path, needs, error));
    fail<std::runtime_error>("cannot be written: {}", system_words(error));
  };
  if (is_stream(path)) {
    const int id = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    const bool good = id >= 0 && write_text(id, text);
    const int error = errno;
    if (id >= 0) ::close(id);
    errno = error;
    if (!good) fail_to_write(text.size());
    return;
  }
  const output_target target = inspect_target(path, kind, force);
  if (!target.objection.empty()) throw std::runtime_error(target.objection);
  part_file part(path);
  if (!part.good() || !write_text(part.id(), text)) {
    const int error = errno;
    part = {};  // what is free without it
    errno = error;
    fail_to_write(text.size());
  }
  if (!part.rename_to(path)) fail_to_write(text.size());
}

}  // namespace talus::detail
