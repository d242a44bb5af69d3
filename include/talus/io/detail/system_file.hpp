#pragma once
// Files by the system's own functions, where HDF5 is not asked.
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

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

}  // namespace talus::detail
