#pragma once
// Texts of users, such as names of files, where others read them: in JSON and TOML, and on a
// terminal.
#include <string>
#include <string_view>

namespace talus::detail {

/// Whether a text is UTF-8 (RFC 3629).
[[nodiscard, gnu::cold]] bool is_utf8(std::string_view text);
/// A text in quotes, as JSON and TOML have it, and safe within a script of HTML. For each byte that
/// is not UTF-8 it has U+FFFD.
[[nodiscard, gnu::cold]] std::string quoted_text(std::string_view text);
/// A text without what controls a terminal and without bytes that are not UTF-8, which stand as
/// \x1b; lines and tabs stay.
[[nodiscard, gnu::cold]] std::string printable(std::string_view text);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/core/shown_text_definitions.hpp"
#endif
