#pragma once
// The index of a series of files: its files and their times, as ParaView reads it (JSON, one file a
// line).
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/output_file.hpp"
#include "talus/io/detail/system_file.hpp"
#include "talus/io/output_kinds.hpp"

namespace talus::detail {

/// On rank 0. The file is complete at any time: each line replaces the end of the file, together
/// with a new end, by one write.
class series_index {
 public:
  explicit series_index(std::string file, bool force = false)
      : file_(std::move(file)), force_(force) {}

  /// Throws runtime_error if no index can be made. True if one exists.
  [[gnu::cold]] bool require_writable() const {
    const output_target target = inspect_target(file_, series_output, force_);
    if (!target.objection.empty())
      fail<std::runtime_error>("the output {} {}", file_, target.objection);
    if (!part_file(file_).good()) fail_to_write();
    return target.replaces;
  }
  /// Calls f(name) for the files of an existing index.
  template <class F>
  void each_name(F&& f) const {
    each_line_before(~std::uint64_t{0}, [&](const std::string& line, std::uint64_t) {
      const auto quote = line.find("\", \"time\": ");
      const auto begin = line.find(name_mark) + name_mark.size();
      f(line.substr(begin, quote - begin));
    });
  }
  /// A new index, which replaces an existing one.
  [[gnu::cold]] void begin() { replace(""); }
  /// The step of the last line before those of step `end`, if there is one.
  [[nodiscard, gnu::cold]] std::optional<std::uint64_t> last_before(std::uint64_t end) const {
    std::optional<std::uint64_t> last;
    each_line_before(end, [&](const std::string&, std::uint64_t step) { last = step; });
    return last;
  }
  /// Continues the existing index, without the lines of step `end` and later ones.
  [[gnu::cold]] void go_on(std::uint64_t end) {
    std::string kept;
    each_line_before(end, [&](const std::string& line, std::uint64_t) {
      kept += (kept.empty() ? "" : ",\n") + line;
    });
    replace(kept);
  }
  /// Adds a file, which lies beside the index.
  [[gnu::cold]] void add(const std::string& name, double time) {
    std::string line = empty_ ? "" : ",\n";
    line += "    {\"name\": \"" + name + "\", \"time\": " + text(time) + "}";
    const system_file file(file_, O_RDWR | O_NOFOLLOW);
    const std::string bytes = line + std::string(foot);
    if (!file.good() || write_at(file.id(), at_, std::as_bytes(std::span(bytes))) != bytes.size())
      fail_to_write(bytes.size());
    at_ += line.size();
    empty_ = false;
  }

 private:
  static constexpr std::string_view head =
      "{\n  \"file-series-version\": \"1.0\",\n  \"files\": [\n";
  static constexpr std::string_view name_mark = "{\"name\": \"";
  static constexpr std::string_view foot = "\n  ]\n}\n";

  /// The number before the last dot of the file name in a line.
  [[nodiscard]] static std::optional<std::uint64_t> step_of(const std::string& line) {
    const auto name = line.find(name_mark);
    const auto quote = line.find("\", \"time\": ");
    const auto dot = line.rfind('.', quote);
    const auto digits = line.rfind('_', dot);
    if (name == line.npos || quote == line.npos || dot == line.npos || digits == line.npos)
      return std::nullopt;
    return std::strtoull(line.c_str() + digits + 1, nullptr, 10);
  }
  /// Calls f(line without its comma, step).
  template <class F>
  void each_line_before(std::uint64_t end, F&& f) const {
    std::string line;
    for (std::ifstream there(file_); std::getline(there, line);) {
      const std::optional<std::uint64_t> step = step_of(line);
      if (!step || *step >= end) continue;
      if (line.back() == ',') line.pop_back();
      f(line, *step);
    }
  }
  [[noreturn, gnu::cold]] void fail_to_write(std::uint64_t bytes = 0) const {
    const int error = errno;
    if (bytes > 0 && no_room(error))
      fail<std::runtime_error>("the output {} cannot be written: {}", file_,
                               words_of_missing_room(file_, bytes, error));
    fail<std::runtime_error>(
        "the output {} cannot be written: {}; name a file in a folder that exists, is writable and "
        "has room",
        file_, system_words(error));
  }
  [[gnu::cold]] void replace(const std::string& lines) {
    try {
      write_output(file_, std::string(head) + lines + std::string(foot), series_output, force_);
    } catch (const std::exception& e) {
      fail<std::runtime_error>("the output {} {}", file_, e.what());
    }
    at_ = head.size() + lines.size();
    empty_ = lines.empty();
  }

  std::string file_;
  bool force_;
  std::uint64_t at_ = 0;  ///< the position of the end
  bool empty_ = true;
};

}  // namespace talus::detail
