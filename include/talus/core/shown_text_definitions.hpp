#pragma once
// The definitions of shown_text.hpp, in the compiled part or in each program.
#include <cstddef>

#include "talus/core/linkage.hpp"
#include "talus/core/shown_text.hpp"

namespace talus::detail {

/// The bytes of the character of UTF-8 at the beginning of a text that is not empty; 0 if it is
/// none.
[[nodiscard, gnu::cold]] inline std::size_t first_character(std::string_view text) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U;
  };
  const unsigned first = byte(0);
  const std::size_t bytes = first < 0x80                    ? 1
                            : first >= 0xc2 && first < 0xe0 ? 2
                            : first >= 0xe0 && first < 0xf0 ? 3
                            : first >= 0xf0 && first < 0xf5 ? 4
                                                            : 0;
  for (std::size_t more = 1; more < bytes; ++more)
    if ((byte(more) & 0xc0) != 0x80) return 0;
  // Neither longer than needed, nor half of a pair of UTF-16, nor beyond the last character.
  const unsigned second = byte(1);
  const bool wrong = (first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
                     (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90);
  return wrong ? 0 : bytes;
}

TALUS_INLINE bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = first_character(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

/// Two hexadecimal digits behind `before`.
[[nodiscard]] inline std::string escaped(const char* before, char c) {
  constexpr const char* digits = "0123456789abcdef";
  const auto code = static_cast<unsigned char>(c);
  return std::string(before) + digits[code >> 4] + digits[code & 15];
}

TALUS_INLINE std::string quoted_text(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t bytes = first_character(text);
    const char c = text.front();
    if (bytes == 0)
      out += "\\ufffd";
    else if (c == '"' || c == '\\')
      (out += '\\') += c;
    else if (bytes == 1 && (static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == '<'))
      out += escaped("\\u00", c);
    else
      out += text.substr(0, bytes);
    text.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return out += '"';
}

/// Whether a character changes the direction of the text behind it.
[[nodiscard]] inline bool turns_text(std::string_view character) {
  if (character.size() != 3 || character[0] != '\xe2') return false;
  const auto second = static_cast<unsigned char>(character[1]),
             third = static_cast<unsigned char>(character[2]);
  return second == 0x80 ? third == 0x8e || third == 0x8f || (third >= 0xaa && third <= 0xae)
                        : second == 0x81 && third >= 0xa6 && third <= 0xa9;
}

TALUS_INLINE std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t bytes = first_character(text);
    const char c = text.front();
    // In UTF-8 the control characters beyond ASCII are two bytes.
    if (bytes == 2 && c == '\xc2' && (text[1] & 0xe0) == 0x80)
      out += escaped("\\x", text[1]);
    else if (turns_text(text.substr(0, bytes)))
      out += escaped("\\u20", static_cast<char>((text[1] & 1) << 6 | (text[2] & 0x3f)));
    else if (bytes == 0 || c == 0x7f ||
             (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t'))
      out += escaped("\\x", c);
    else
      out += text.substr(0, bytes);
    text.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return out;
}

}  // namespace talus::detail
