#pragma once
// The index of a series of files: its files and their times, as ParaView reads it (JSON, one file a
// line).
#include <fcntl.h>
#include <sys/stat.h>
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
#include "talus/core/shown_text.hpp"
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
  [[gnu::cold]] bool require_writable() const;
  /// Calls f(name in quotes) for the files of an existing index.
  template <class F>
  void each_name(F&& f) const {
    each_line_before(~std::uint64_t{0}, [&](const std::string& line, std::uint64_t) {
      const auto begin = line.find(name_mark) + name_mark.size();
      f(line.substr(begin, line.find(time_mark) - begin));
    });
  }
  /// A new index, which replaces an existing one.
  [[gnu::cold]] void begin() { replace(""); }
  /// The step of the last line before those of step `end`, if there is one.
  [[nodiscard, gnu::cold]] std::optional<std::uint64_t> last_before(std::uint64_t end) const;
  /// Continues the existing index, without the lines of step `end` and later ones.
  [[gnu::cold]] void go_on(std::uint64_t end);
  /// Adds a file, which lies beside the index. Throws runtime_error if that is not the index that
  /// this has begun.
  [[gnu::cold]] void add(const std::string& name, double time);

 private:
  static constexpr std::string_view head =
      "{\n  \"file-series-version\": \"1.0\",\n  \"files\": [\n";
  static constexpr std::string_view name_mark = "{\"name\": ", time_mark = ", \"time\": ";
  static constexpr std::string_view foot = "\n  ]\n}\n";

  /// The number before the last dot of the file name in a line.
  [[nodiscard]] static std::optional<std::uint64_t> step_of(const std::string& line);
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
  [[noreturn, gnu::cold]] void fail_to_write(std::uint64_t bytes = 0) const;
  [[gnu::cold]] void replace(const std::string& lines);

  std::string file_;
  bool force_;
  std::uint64_t at_ = 0;    ///< the position of the end
  struct stat written_ {};  ///< which file it is
  bool empty_ = true;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/series_index_definitions.hpp"
#endif
