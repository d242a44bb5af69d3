#pragma once
// Frames of the viewer's page, from what the ranks contribute: the same for any number of ranks,
// except for the rank of each body. docs/view.md describes the blocks of a frame.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/io/detail/view_blocks.hpp"
#include "talus/io/detail/view_content.hpp"
#include "talus/io/detail/view_part.hpp"

namespace talus::detail {

/// The head of a frame that adds rows to the table of the page and is not shown, and how many of
/// the frame's bytes it needs.
struct view_table {
  std::string head;
  std::size_t bytes = 0;
};
/// A frame: its head and the bytes of its blocks.
struct view_frame {
  view_json head;
  byte_buffer bytes;
  std::string warning;  ///< of bodies that are left out; empty: none
  /// What later frames use of it: heads for the beginning of the bytes, without the rows of its
  /// bodies and with them. Empty: nothing.
  view_table table, table_with_rows;
};

/// Makes frames on rank 0, one after another. Its memory grows with the number of bodies that the
/// run has had so far, not with the number of frames.
class view_frames {
 public:
  /// `contacts`: frames hold each contact, not only what they add up to for each body.
  explicit view_frames(bool contacts = false) : contacts_(contacts) {}
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
  void add_rows(const plain_vector<view_body>& all, plain_vector<std::uint32_t>& rows,
                view_blocks& to, view_frame& out);
  [[nodiscard]] std::int32_t number_of(std::uint64_t form) const;

  bool contacts_ = false;
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
