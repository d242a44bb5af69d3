#pragma once
// The page of --view: one HTML file that shows a run in a browser. docs/view.md.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "talus/core/output_file.hpp"
#include "talus/io/detail/view_frames.hpp"
#include "talus/io/output_kinds.hpp"

namespace talus::detail {

/// The file of three.js: TALUS_THREE of the environment, or that of Debian's package libjs-three.
[[nodiscard, gnu::cold]] std::string three_file();
/// The text of three_file(). Throws runtime_error, with what to install, if there is no such file.
[[nodiscard, gnu::cold]] std::string read_three();

/// Writes a page frame by frame, on rank 0. Frames go to the disk at once, into a temporary file
/// beside the page, which gets the page's name when it is complete.
class view_page {
 public:
  /// Throws runtime_error if the file must not be replaced or cannot be written, or if three.js is
  /// missing.
  [[gnu::cold]] view_page(std::string file, bool force);
  view_page(const view_page&) = delete;
  view_page& operator=(const view_page&) = delete;
  /// Completes a page that has frames, if finish() was not called: an error has ended the run.
  ~view_page();

  /// `about` is the JSON object that describes the run; the first call writes it.
  [[gnu::cold]] void add(const view_frame& frame, std::uint64_t step, const std::string& about);
  /// Removes all frames but those of these steps, and keeps what they use of the others. Throws
  /// runtime_error on failure.
  [[gnu::cold]] void keep(std::span<const std::uint64_t> steps);
  /// Completes the page; `end` is the JSON object at its end. Throws runtime_error on failure.
  [[gnu::cold]] void finish(const std::string& end);
  [[nodiscard]] std::uint64_t frames() const { return frames_; }

 private:
  /// A frame in the file: its place, the place of its data, and what it leaves when it is removed.
  struct place {
    std::uint64_t step = 0, begin = 0, data = 0, end = 0;
    view_table table, table_with_rows;
    bool shown = true;
  };
  [[gnu::cold]] void write(std::string_view text);
  [[gnu::cold]] void write_element(const char* name, const std::string& json);
  [[gnu::cold]] void move(std::uint64_t from, std::uint64_t end);
  [[noreturn, gnu::cold]] void fail_to_write(std::uint64_t needs);

  std::string file_;
  bool force_;
  part_file part_;
  std::uint64_t frames_ = 0, written_ = 0;  ///< frames so far, also removed ones; bytes in the file
  std::vector<place> places_;
};

/// Appends the characters of base64 for some bytes.
[[gnu::cold]] void append_base64(std::string& to, std::span<const std::byte> bytes);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/view_page_definitions.hpp"
#endif
