#pragma once
// Files by system calls, for file access without HDF5.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/output_file.hpp"

namespace talus::detail {

/// Reads bytes of an open file. False at its end, and if reading fails.
[[nodiscard]] bool read_at(int file, std::uint64_t at, std::span<std::byte> into);
/// Writes bytes of an open file. Returns how many, and sets errno if these are not all.
[[nodiscard]] std::size_t write_at(int file, std::uint64_t at, std::span<const std::byte> from);

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

/// Throws runtime_error if this process may not write so long a file.
[[gnu::cold]] void require_size_allowed(std::uint64_t bytes);

/// Makes an empty file `bytes` long and reserves room on the disk for all of it, so that a full
/// disk is detected here, where one rank fails alone. Returns the error, or 0. (If the file system
/// cannot reserve room, the rank that writes to a full disk detects it.)
[[nodiscard, gnu::cold]] int reserve_file(int file, std::uint64_t bytes);

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/system_file_definitions.hpp"
#endif
