#pragma once
// What readers of files from elsewhere have in common.
#include <sys/stat.h>

#include <string>
#include <string_view>

namespace talus::detail {

/// The first bytes of a text from a program that marks UTF-8.
inline constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";

/// A folder can be opened like a file, and then not be read.
[[nodiscard, gnu::cold]] inline bool is_folder(const std::string& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 && S_ISDIR(found.st_mode);
}

}  // namespace talus::detail
