#pragma once
// Functions shared by the readers of external files.
#include <sys/stat.h>

#include <cstdio>
#include <istream>
#include <string>
#include <string_view>

namespace talus::detail {

/// The byte order mark with which some programs begin UTF-8 texts.
inline constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

/// A folder can be opened like a file, but not read.
[[nodiscard, gnu::cold]] inline bool is_folder(const std::string& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode);
}

/// The next line, which ends with a line feed, a carriage return, or both. False after the last.
[[nodiscard, gnu::cold]] inline bool read_line(std::istream& in, std::string& line) {
  line.clear();
  std::streambuf& from = *in.rdbuf();
  int c = from.sbumpc();
  if (c == EOF) return false;
  for (; c != EOF && c != '\n' && c != '\r'; c = from.sbumpc()) line += static_cast<char>(c);
  if (c == '\r' && from.sgetc() == '\n') from.sbumpc();
  return true;
}

}  // namespace talus::detail
