#pragma once
// Files by the system's own functions, where HDF5 is not asked.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>

#include "talus/core/error.hpp"

namespace talus::detail {

/// An open file, by the system's own functions.
class system_file {
 public:
  system_file(const std::string& path, int flags) : id_(::open(path.c_str(), flags, 0666)) {}
  system_file(const system_file&) = delete;
  system_file& operator=(const system_file&) = delete;
  ~system_file() {
    if (id_ >= 0) ::close(id_);
  }
  [[nodiscard]] bool good() const { return id_ >= 0; }
  [[nodiscard]] int id() const { return id_; }
  /// False at the end of the file, and where reading fails.
  [[nodiscard]] bool read(std::uint64_t at, std::span<std::byte> into) const {
    while (!into.empty()) {
      const ssize_t n = ::pread(id_, into.data(), into.size(), static_cast<off_t>(at));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      into = into.subspan(static_cast<std::size_t>(n));
      at += static_cast<std::uint64_t>(n);
    }
    return true;
  }
  [[nodiscard]] bool write(std::uint64_t at, std::span<const std::byte> from) const {
    while (!from.empty()) {
      const ssize_t n = ::pwrite(id_, from.data(), from.size(), static_cast<off_t>(at));
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      from = from.subspan(static_cast<std::size_t>(n));
      at += static_cast<std::uint64_t>(n);
    }
    return true;
  }

 private:
  int id_;
};

[[nodiscard, gnu::cold]] inline std::string system_words(int error = errno) {
  return std::strerror(error);
}

/// A write beyond the limit of file sizes shall fail, not end the process.
class no_size_signal {
 public:
  no_size_signal() : before_(std::signal(SIGXFSZ, SIG_IGN)) {}
  no_size_signal(const no_size_signal&) = delete;
  no_size_signal& operator=(const no_size_signal&) = delete;
  ~no_size_signal() {
    if (before_ != SIG_ERR) std::signal(SIGXFSZ, before_);
  }

 private:
  void (*before_)(int);
};

/// Throws runtime_error where this process may not write so long a file.
[[gnu::cold]] inline void require_size_allowed(std::uint64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      bytes > limit.rlim_cur)
    fail<std::runtime_error>(
        "cannot be written: it needs some {} bytes, and files may have {} (ulimit -f): raise "
        "that limit",
        bytes, static_cast<std::uint64_t>(limit.rlim_cur));
}

/// Asks for room on the disk for all of a file, so that a full one is found out here, where one
/// rank fails alone. Returns the length of the file.
[[gnu::cold]] inline std::uint64_t reserve_file(const std::string& path) {
  const system_file file(path, O_RDWR);
  struct stat found {};
  if (!file.good() || ::fstat(file.id(), &found) != 0)
    fail<std::runtime_error>("cannot be written: {}", system_words());
  int failed = 0;
  do {
    failed = ::fallocate(file.id(), 0, 0, found.st_size) != 0 ? errno : 0;
  } while (failed == EINTR);
  if (failed != 0 && failed != EOPNOTSUPP && failed != ENOSYS)
    fail<std::runtime_error>(
        "cannot be written: there is no room for {} bytes more ({}): make room, or name a file on "
        "another disk",
        static_cast<std::uint64_t>(found.st_size), system_words(failed));
  return static_cast<std::uint64_t>(found.st_size);
}

}  // namespace talus::detail
