#pragma once
// Surfaces from STL files, the common export format of CAD programs: text or binary.
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/input_file.hpp"
#include "talus/shape/triangle_mesh.hpp"

namespace talus {

namespace detail {

/// A binary STL has 80 bytes of title, the number of triangles, and 50 bytes for each: its normal,
/// which is ignored, three corners, and two further bytes. All numbers are little-endian.
[[nodiscard]] inline std::vector<triangle_mesh::triangle> triangles_of_binary_stl(
    std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, 4);
  std::vector<triangle_mesh::triangle> triangles(count);
  const char* at = bytes.data() + 84;
  for (auto& t : triangles) {
    std::array<float, 9> numbers;
    std::memcpy(numbers.data(), at + 12, sizeof numbers);
    for (std::size_t k = 0; k < 3; ++k)
      t[k] = {numbers[3 * k], numbers[3 * k + 1], numbers[3 * k + 2]};
    at += 50;
  }
  return triangles;
}

/// The words of a text with the numbers of their lines, for any ends of lines.
class stl_words {
 public:
  explicit stl_words(std::string_view text) : text_(text) {}

  /// The next word, in lower case; empty at the end.
  std::string next() {
    for (; at_ < text_.size() && is_blank(text_[at_]); ++at_) {
      const bool of_both = text_[at_] == '\n' && at_ > 0 && text_[at_ - 1] == '\r';
      if ((text_[at_] == '\n' || text_[at_] == '\r') && !of_both) ++line_;
    }
    std::string word;
    for (; at_ < text_.size() && !is_blank(text_[at_]); ++at_)
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(text_[at_])));
    return word;
  }
  /// The line of the last word.
  [[nodiscard]] std::size_t line() const { return line_; }

 private:
  [[nodiscard]] static bool is_blank(char c) {
    return std::isspace(static_cast<unsigned char>(c)) != 0;
  }

  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
};

/// Whether the next word is a number.
[[nodiscard]] inline bool is_number_next(stl_words words) {
  const std::string word = words.next();
  char* end = nullptr;
  (void)std::strtod(word.c_str(), &end);
  return !word.empty() && *end == 0;
}

/// What stands before a facet, such as a title or remarks, is left out, and so is the title behind
/// 'solid', at the beginning of a line, or 'endsolid', whatever its words, up to the end of its
/// line or 'facet normal' with a number. Throws runtime_error, with the number of the line, for an
/// invalid number.
[[nodiscard]] inline std::vector<triangle_mesh::triangle> triangles_of_text_stl(
    const std::string& text, const std::string& file) {
  std::vector<triangle_mesh::triangle> triangles;
  std::vector<vec3> corners;
  bool inside = false, ended = false;
  std::size_t title = 0, line_before = 0;  // their lines
  stl_words words(text);
  std::string last;
  for (std::string word = words.next(); !word.empty(); last = word, word = words.next()) {
    const bool in_title = words.line() == title, first = words.line() != line_before;
    line_before = words.line();
    if (in_title ? last == "facet" && word == "normal" && is_number_next(words) : word == "facet") {
      inside = true, ended = false, title = 0;
    } else if (in_title) {
      continue;
    } else if ((word == "solid" && first) || word == "endsolid") {
      if (inside)
        fail<std::runtime_error>("the facet before line {} of the STL file {} has no 'endfacet'",
                                 words.line(), file);
      ended = word == "endsolid", title = words.line();
    } else if (inside && word == "vertex") {
      const std::size_t line = words.line();
      vec3 v;
      for (int k = 0; k < 3; ++k) {
        const std::string number = words.next();
        char* end = nullptr;
        v[k] = std::strtod(number.c_str(), &end);
        if (number.empty() || *end != 0)
          fail<std::runtime_error>(
              "line {} of the STL file {} should be 'vertex x y z', but {} is '{}'", line, file,
              "xyz"[k], number);
      }
      corners.push_back(v);
    } else if (word == "endfacet") {
      if (corners.size() != 3)
        fail<std::runtime_error>(
            "the facet that ends in line {} of the STL file {} has {} corners instead of 3",
            words.line(), file, corners.size());
      triangles.push_back({corners[0], corners[1], corners[2]});
      corners.clear(), inside = false;
    }
  }
  if (!ended)
    fail<std::runtime_error>("the STL file {} ends without 'endsolid': it was cut off", file);
  return triangles;
}

/// Whether these are the bytes of a text in whose words a surface begins.
[[nodiscard]] inline bool is_text_stl(std::string_view bytes) {
  if (bytes.find('\0') != bytes.npos) return false;
  stl_words words(bytes);
  for (std::string word = words.next(); !word.empty(); word = words.next())
    if (word == "solid" || word == "facet") return true;
  return false;
}

}  // namespace detail

/// The surface in an STL file, text or binary, all lengths times `scale`. Throws runtime_error for
/// a file that cannot be read or is cut off, with the line of a text file, and invalid_argument as
/// triangle_mesh does. `report` gets what that finds: open edges, and corners that it joined.
[[nodiscard]] inline triangle_mesh read_stl(const std::string& file, real scale = 1,
                                            surface_report* report = nullptr) {
  detail::require_positive(scale, "the scale of an STL file");
  if (detail::is_folder(file))
    detail::fail<std::runtime_error>("the STL file {} is a folder: name the file in it", file);
  std::ifstream in(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (!in.is_open() || in.bad())
    detail::fail<std::runtime_error>(
        "the STL file {} cannot be read: is the name right, seen from the folder in which the "
        "program runs?",
        file);
  if (bytes.starts_with(detail::byte_order_mark)) bytes.erase(0, detail::byte_order_mark.size());
  std::uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, 4);
  // (Some binary files begin with the keyword of text files, and some end with a few bytes more.)
  const std::size_t needed = 84 + 50 * std::size_t{count};
  const bool binary = bytes.size() >= needed && bytes.size() < needed + 50;
  if (!binary && !detail::is_text_stl(bytes)) {
    if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff"))
      detail::fail<std::runtime_error>("the STL file {} is in UTF-16: save it as UTF-8", file);
    // (Of what is no text either, such as a picture, that number has no meaning.)
    if (bytes.size() >= 84 && count < (std::uint32_t{1} << 24))
      detail::fail<std::runtime_error>(
          "{} is no STL file, or is cut off: it has {} bytes, and says that it holds {} triangles, "
          "which take {}",
          file, bytes.size(), count, needed);
    detail::fail<std::runtime_error>(
        "{} is no STL file: it is neither a text with the words 'solid' and 'facet' nor a binary "
        "file of triangles",
        file);
  }
  auto triangles =
      binary ? detail::triangles_of_binary_stl(bytes) : detail::triangles_of_text_stl(bytes, file);
  for (auto& t : triangles)
    for (vec3& v : t) v *= scale;
  try {
    return triangle_mesh(triangles, report);
  } catch (const std::invalid_argument& e) {
    detail::fail<std::invalid_argument>("the STL file {}: {}", file, e.what());
  }
}

}  // namespace talus
