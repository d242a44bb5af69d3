#pragma once
// The definitions of shown_text.hpp, in the compiled part or in each program.
#include <cstddef>

#include "talus/core/linkage.hpp"
#include "talus/core/shown_text.hpp"

namespace talus::detail {

TALUS_INLINE bool is_utf8(std::string_view text) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U;
  };
  for (std::size_t k = 0; k < text.size();) {
    const unsigned first = byte(k);
    const std::size_t bytes = first < 0x80                    ? 1
                              : first >= 0xc2 && first < 0xe0 ? 2
                              : first >= 0xe0 && first < 0xf0 ? 3
                              : first >= 0xf0 && first < 0xf5 ? 4
                                                              : 0;
    if (bytes == 0) return false;
    for (std::size_t more = 1; more < bytes; ++more)
      if ((byte(k + more) & 0xc0) != 0x80) return false;
    // Neither longer than needed, nor half of a pair of UTF-16, nor beyond the last character.
    const unsigned second = byte(k + 1);
    if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
        (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90))
      return false;
    k += bytes;
  }
  return true;
}

/// Two hexadecimal digits behind `before`.
[[nodiscard]] inline std::string escaped(const char* before, char c) {
  constexpr const char* digits = "0123456789abcdef";
  const auto code = static_cast<unsigned char>(c);
  return std::string(before) + digits[code >> 4] + digits[code & 15];
}

TALUS_INLINE std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      (out += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == '<')
      out += escaped("\\u00", c);
    else
      out += c;
  }
  return out += '"';
}

TALUS_INLINE std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto code = static_cast<unsigned char>(text[k]);
    // In UTF-8 the control characters beyond ASCII are two bytes.
    if (code == 0xc2 && k + 1 < text.size() && (text[k + 1] & 0xe0) == 0x80)
      out += escaped("\\x", text[++k]);
    else if ((code < 0x20 && code != '\n' && code != '\t') || code == 0x7f)
      out += escaped("\\x", text[k]);
    else
      out += text[k];
  }
  return out;
}

}  // namespace talus::detail
