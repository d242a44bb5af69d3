#pragma once
// Files by system calls, for file access without HDF5.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/output_file.hpp"

namespace talus::detail {

/// Reads bytes of an open file. False at its end, and if reading fails.
[[nodiscard]] inline bool read_at(int file, std::uint64_t at, std::span<std::byte> into) {
  while (!into.empty()) {
    const ssize_t n = ::pread(file, into.data(), into.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(n));
    at += static_cast<std::uint64_t>(n);
  }
  return true;
}
/// Writes bytes of an open file. Returns how many, and sets errno if these are not all.
[[nodiscard]] inline std::size_t write_at(int file, std::uint64_t at,
                                          std::span<const std::byte> from) {
  std::size_t written = 0;
  while (written < from.size()) {
    const ssize_t n = ::pwrite(file, from.data() + written, from.size() - written,
                               static_cast<off_t>(at + written));
    if (n < 0 && errno == EINTR) continue;
    if (n == 0) errno = ENOSPC;
    if (n <= 0) break;
    written += static_cast<std::size_t>(n);
  }
  return written;
}

/// An open file, by system calls.
class system_file {
 public:
  system_file(const std::string& path, int flags)
      : id_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  system_file(const system_file&) = delete;
  system_file& operator=(const system_file&) = delete;
  ~system_file() {
    if (id_ >= 0) ::close(id_);
  }
  [[nodiscard]] bool good() const { return id_ >= 0; }
  [[nodiscard]] int id() const { return id_; }
  [[nodiscard]] bool read(std::uint64_t at, std::span<std::byte> into) const {
    return read_at(id_, at, into);
  }

 private:
  int id_;
};

/// A write beyond the limit of file sizes must fail instead of ending the process.
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

/// Throws runtime_error if this process may not write so long a file.
[[gnu::cold]] inline void require_size_allowed(std::uint64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      bytes > limit.rlim_cur)
    fail<std::runtime_error>(
        "cannot be written: it needs some {} bytes, and files may have {} (ulimit -f), {} bytes "
        "are missing: raise that limit",
        bytes, static_cast<std::uint64_t>(limit.rlim_cur),
        bytes - static_cast<std::uint64_t>(limit.rlim_cur));
}

/// Whether an error means that there is no room.
[[nodiscard]] inline bool no_room(int error) {
  return error == ENOSPC || error == EDQUOT || error == EFBIG;
}

/// Makes an empty file `bytes` long and reserves room on the disk for all of it, so that a full
/// disk is detected here, where one rank fails alone. Returns the error, or 0. (If the file system
/// cannot reserve room, the rank that writes to a full disk detects it.)
[[nodiscard, gnu::cold]] inline int reserve_file(int file, std::uint64_t bytes) {
  if (::ftruncate(file, static_cast<off_t>(bytes)) != 0) return errno;
  int failed = 0;
  do {
    failed = ::fallocate(file, 0, 0, static_cast<off_t>(bytes)) != 0 ? errno : 0;
  } while (failed == EINTR);
  return failed == EOPNOTSUPP || failed == ENOSYS ? 0 : failed;
}

}  // namespace talus::detail
