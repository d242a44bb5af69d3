#pragma once
// Frames of the viewer's page, from what the ranks contribute: the same for any number of ranks,
// except for the rank of each body. docs/view.md describes the blocks of a frame.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/io/detail/view_part.hpp"

namespace talus::detail {

/// A growing JSON object. Numbers that are not finite become null.
class view_json {
 public:
  [[gnu::cold]] void add(std::string_view key, double value);
  [[gnu::cold]] void add_text(std::string_view key, std::string_view text);
  /// A value that is JSON already.
  [[gnu::cold]] void add_raw(std::string_view key, std::string_view json);
  [[nodiscard]] std::string str() const { return "{" + text_ + "}"; }
  /// A text in quotation marks, also fit for a script element of a page.
  [[nodiscard, gnu::cold]] static std::string quoted(std::string_view text);
  [[nodiscard, gnu::cold]] static std::string number(double value);
  /// A list of three numbers.
  [[nodiscard, gnu::cold]] static std::string vector(const vec3& v);

 private:
  std::string text_;
};

/// A frame: its head and the bytes of its blocks.
struct view_frame {
  view_json head;
  byte_buffer bytes;
  std::string warning;  ///< of bodies that are left out; empty: none
};

/// Makes frames on rank 0, one after another. Its memory grows with the number of bodies that the
/// run has had so far, not with the number of frames.
class view_frames {
 public:
  /// Of each frame the strongest contacts are stored, at most so many.
  static constexpr std::size_t most_contacts = 50000;

  class blocks;

  [[nodiscard, gnu::cold]] view_frame make(std::vector<view_part>& parts);

 private:
  /// A body that a frame has had, and its row in the table of the page.
  struct known_body {
    view_body body;
    std::uint32_t row = 0;
  };
  struct known_form {
    std::uint64_t id = 0;
    std::int32_t number = -1;  ///< -1: no body has it yet
    std::uint32_t at = 0;      ///< in `pending_`
  };

  void leave_out(plain_vector<view_body>& all, view_frame& out) const;
  void measure(plain_vector<view_body>& all);
  void add_rows(const plain_vector<view_body>& all, plain_vector<std::uint32_t>& rows, blocks& to,
                view_frame& out);
  [[nodiscard]] std::int32_t number_of(std::uint64_t form) const;

  plain_vector<known_body> known_;  ///< in the order of ids and parts
  std::uint32_t rows_ = 0;
  plain_vector<std::uint32_t> shown_;  ///< rows of the last frame
  plain_vector<known_form> forms_;     ///< in the order of their ids
  std::vector<view_form> pending_;     ///< forms that no frame contains yet
  std::int32_t numbered_forms_ = 0;
  std::string domains_;  ///< as in the last head that has them
  vec3 middle_{0, 0, 0};
  double reach_ = 0;  ///< half the edge of the pieces of planes that are drawn
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/detail/view_frames_definitions.hpp"
#endif
