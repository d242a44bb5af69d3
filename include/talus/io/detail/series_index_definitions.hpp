#pragma once
// The definitions of series_index.hpp, in the compiled part or in each program.
#include "talus/io/detail/hdf5_linkage.hpp"
#include "talus/io/detail/series_index.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE bool series_index::require_writable() const {
  const output_target target = inspect_target(file_, series_output, force_);
  if (!target.objection.empty())
    fail<std::runtime_error>("the output {} {}", file_, target.objection);
  if (!part_file(file_).good()) fail_to_write();
  return target.replaces;
}

TALUS_HDF5_INLINE std::optional<std::uint64_t> series_index::last_before(std::uint64_t end) const {
  std::optional<std::uint64_t> last;
  each_line_before(end, [&](const std::string&, std::uint64_t step) { last = step; });
  return last;
}

TALUS_HDF5_INLINE void series_index::go_on(std::uint64_t end) {
  std::string kept;
  each_line_before(end, [&](const std::string& line, std::uint64_t) {
    kept += (kept.empty() ? "" : ",\n") + line;
  });
  replace(kept);
}

TALUS_HDF5_INLINE void series_index::add(const std::string& name, double time) {
  std::string line = empty_ ? "" : ",\n";
  ((((line += "    ") += name_mark) += detail::quoted_text(name)) += time_mark) += text(time) + "}";
  const std::string bytes = line + std::string(foot);
  const system_file file(file_, O_RDWR | O_NOFOLLOW);
  struct stat found {};
  const bool other =
      file.good() ? ::fstat(file.id(), &found) == 0 &&
                        (found.st_dev != written_.st_dev || found.st_ino != written_.st_ino ||
                         static_cast<std::uint64_t>(found.st_size) != at_ + foot.size())
                  : errno == ENOENT || errno == ELOOP || errno == EISDIR;
  if (other)
    fail<std::runtime_error>(
        "the output {} is no longer the index that this run has begun: something else has removed, "
        "replaced or changed it; begin again with another name",
        file_);
  if (!file.good() || write_at(file.id(), at_, std::as_bytes(std::span(bytes))) != bytes.size()) {
    const int error = errno;
    // What was there before has room.
    if (file.good() && write_at(file.id(), at_, std::as_bytes(std::span(foot))) == foot.size())
      (void)::ftruncate(file.id(), static_cast<off_t>(at_ + foot.size()));
    errno = error;
    fail_to_write(bytes.size());
  }
  at_ += line.size();
  empty_ = false;
}

TALUS_HDF5_INLINE std::optional<std::uint64_t> series_index::step_of(const std::string& line) {
  const auto name = line.find(name_mark);
  const auto quote = line.find(std::string("\"") + std::string(time_mark));
  const auto dot = line.rfind('.', quote);
  const auto digits = line.rfind('_', dot);
  if (name == line.npos || quote == line.npos || dot == line.npos || digits == line.npos)
    return std::nullopt;
  return std::strtoull(line.c_str() + digits + 1, nullptr, 10);
}

TALUS_HDF5_INLINE void series_index::fail_to_write(std::uint64_t bytes) const {
  fail<std::runtime_error>("the output {} cannot be written: {}", file_,
                           words_of_failed_write(file_, bytes, errno));
}

TALUS_HDF5_INLINE void series_index::replace(const std::string& lines) {
  try {
    write_output(file_, std::string(head) + lines + std::string(foot), series_output, force_);
  } catch (const std::exception& e) {
    fail<std::runtime_error>("the output {} {}", file_, e.what());
  }
  if (::lstat(file_.c_str(), &written_) != 0) fail_to_write();
  at_ = head.size() + lines.size();
  empty_ = lines.empty();
}

}  // namespace talus::detail
