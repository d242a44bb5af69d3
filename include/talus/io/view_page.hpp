#pragma once
// The page of --view: one HTML file that shows a run in a browser. docs/view.md.
#include <cstdint>
#include <string>
#include <string_view>

#include "talus/core/output_file.hpp"
#include "talus/io/detail/view_frames.hpp"
#include "talus/io/output_kinds.hpp"

namespace talus::detail {

/// The file of three.js: TALUS_THREE of the environment, or that of Debian's package libjs-three.
[[nodiscard, gnu::cold]] std::string three_file();
/// Its text. Throws runtime_error, with what to install, if there is none.
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
  [[gnu::cold]] void add(const view_frame& frame, const std::string& about);
  /// Completes the page; `end` is the JSON object at its end. Throws runtime_error on failure.
  [[gnu::cold]] void finish(const std::string& end);
  [[nodiscard]] std::uint64_t frames() const { return frames_; }

 private:
  [[gnu::cold]] void write(std::string_view text);
  [[gnu::cold]] void write_element(const char* name, const std::string& json);

  std::string file_;
  bool force_;
  part_file part_;
  std::uint64_t frames_ = 0;
};

/// Appends the characters of base64 for some bytes.
[[gnu::cold]] void append_base64(std::string& to, std::span<const std::byte> bytes);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/io/view_page_definitions.hpp"
#endif
