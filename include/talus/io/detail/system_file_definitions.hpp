#pragma once
// The definitions of system_file.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/system_file.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE bool read_at(int file, std::uint64_t at, std::span<std::byte> into) {
  while (!into.empty()) {
    const ssize_t n = ::pread(file, into.data(), into.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(n));
    at += static_cast<std::uint64_t>(n);
  }
  return true;
}

TALUS_HDF5_INLINE std::size_t write_at(int file, std::uint64_t at,
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

TALUS_HDF5_INLINE void require_size_allowed(std::uint64_t bytes) {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      bytes > limit.rlim_cur)
    fail<std::runtime_error>(
        "cannot be written: it needs some {} bytes, and files may have {} (ulimit -f), {} bytes "
        "are missing: raise that limit",
        bytes, static_cast<std::uint64_t>(limit.rlim_cur),
        bytes - static_cast<std::uint64_t>(limit.rlim_cur));
}

TALUS_HDF5_INLINE int reserve_file(int file, std::uint64_t bytes) {
  if (::ftruncate(file, static_cast<off_t>(bytes)) != 0) return errno;
  int failed = 0;
  do {
    failed = ::fallocate(file, 0, 0, static_cast<off_t>(bytes)) != 0 ? errno : 0;
  } while (failed == EINTR);
  return failed == EOPNOTSUPP || failed == ENOSYS ? 0 : failed;
}

}  // namespace talus::detail
