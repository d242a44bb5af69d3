#pragma once
// Functions shared by the readers of external files.
#include <sys/stat.h>

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

}  // namespace talus::detail
