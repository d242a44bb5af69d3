#pragma once
// The definitions of view_page.hpp, in the compiled part or in each program.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <utility>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/io/detail/view_page_text.hpp"
#include "talus/io/view_page.hpp"

namespace talus::detail {

TALUS_INLINE std::string three_file() {
  const char* const named = std::getenv("TALUS_THREE");
  return named != nullptr && *named != '\0' ? named : "/usr/share/javascript/three/three.min.js";
}

TALUS_INLINE std::string read_three() {
  const std::string file = three_file();
  std::FILE* const in = std::fopen(file.c_str(), "rb");
  if (in == nullptr)
    fail<std::runtime_error>(
        "the page of --view needs three.js, and {} cannot be read: {}: install Debian's package "
        "libjs-three, or name the file three.min.js in the environment variable TALUS_THREE",
        file, system_words());
  std::string text, piece(1 << 16, '\0');
  while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), in))
    text.append(piece, 0, n);
  std::fclose(in);
  if (text.find("THREE") == text.npos || text.find("</script") != text.npos)
    fail<std::runtime_error>(
        "{} is not three.js as a plain script: name a file three.min.js in the environment "
        "variable TALUS_THREE",
        file);
  return text;
}

TALUS_INLINE void append_base64(std::string& to, std::span<const std::byte> bytes) {
  static constexpr char digits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  to.reserve(to.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    const std::size_t here = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (k < here ? static_cast<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) to += k <= here ? digits[three >> (18 - 6 * k) & 63] : '=';
  }
}

TALUS_INLINE view_page::view_page(std::string file, bool force)
    : file_(std::move(file)), force_(force) {
  const output_target target = inspect_target(file_, view_output, force_);
  if (!target.objection.empty()) fail<std::runtime_error>("--view {} {}", file_, target.objection);
  const std::string three = read_three();
  part_ = part_file(file_);
  if (!part_.good())
    fail<std::runtime_error>("the page {} (--view) cannot be written: {}", file_,
                             words_of_failed_write(file_, 0, errno));
  for (const char* const piece : view_page_before_three) write(piece);
  write(three);
  for (const char* const piece : view_page_before_data) write(piece);
}

TALUS_INLINE view_page::~view_page() {
  if (!part_.good() || frames_ == 0) return;
  try {
    finish("{\"notes\":[\"The run ended before its last step.\"]}");
  } catch (const std::exception&) {  // the error that ends the run is reported
  }
}

TALUS_INLINE void view_page::write(std::string_view text) {
  if (!write_text(part_.id(), text)) fail_to_write(text.size());
  written_ += text.size();
}

TALUS_INLINE void view_page::fail_to_write(std::uint64_t needs) {
  const std::string words = words_of_failed_write(file_, needs, errno);
  part_ = {};
  fail<std::runtime_error>("the page {} (--view) cannot be written: {}", file_, words);
}

TALUS_INLINE void view_page::write_element(const char* name, const std::string& json) {
  write(compose("<script type=\"application/json\" class=\"talus-{}\">", name));
  write(json);
  write("</script>\n");
}

namespace view_words {
inline constexpr std::string_view data = "<script type=\"text/plain\" class=\"talus-data\">",
                                  end = "</script>\n";
}  // namespace view_words

TALUS_INLINE void view_page::add(const view_frame& frame, std::uint64_t step,
                                 const std::string& about) {
  if (frames_++ == 0) write_element("about", about);
  place here{step, written_, 0, 0, frame.table, frame.table_with_rows, true};
  write_element("head", frame.head.str());
  write(view_words::data);
  here.data = written_;
  constexpr std::size_t piece =
      3 << 18;  // a multiple of three: base64 of each ends without padding
  std::string text;
  for (std::size_t at = 0; at < frame.bytes.size(); at += piece) {
    text.clear();
    append_base64(text,
                  std::span(frame.bytes).subspan(at, std::min(piece, frame.bytes.size() - at)));
    write(text);
  }
  write(view_words::end);
  here.end = written_;
  places_.push_back(std::move(here));
}

/// Copies a part of the file to its present end, which is not behind that part.
TALUS_INLINE void view_page::move(std::uint64_t from, std::uint64_t end) {
  std::string piece;
  while (from < end) {
    piece.resize(std::min<std::uint64_t>(end - from, 1 << 20));
    const auto got = pread(part_.id(), piece.data(), piece.size(), static_cast<off_t>(from));
    if (got <= 0) fail_to_write(0);
    write(std::string_view(piece).substr(0, static_cast<std::size_t>(got)));
    from += static_cast<std::uint64_t>(got);
  }
}

TALUS_INLINE void view_page::keep(std::span<const std::uint64_t> steps) {
  if (places_.empty()) return;
  // From the last one to the first: a removed frame leaves its rows if a later one refers to them.
  std::vector<const view_table*> left(places_.size(), nullptr);
  bool refers = true;  // those that follow may
  for (std::size_t k = places_.size(); k-- > 0;) {
    place& p = places_[k];
    const bool rows = !p.table_with_rows.head.empty();
    p.shown = p.shown && std::find(steps.begin(), steps.end(), p.step) != steps.end();
    if (!p.shown) left[k] = rows && refers ? &p.table_with_rows : &p.table;
    if (p.shown || rows) refers = !rows;
  }
  // In place: each frame moves towards the beginning of the file.
  written_ = places_.front().begin;
  if (lseek(part_.id(), static_cast<off_t>(written_), SEEK_SET) < 0) fail_to_write(0);
  std::vector<place> kept;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    place p = std::move(places_[k]);
    const std::uint64_t begin = written_, moved = p.data - p.begin;
    if (p.shown) {
      move(p.begin, p.end);
      p.data = begin + moved;
    } else {
      const view_table table =
          std::move(left[k] == &places_[k].table ? p.table : p.table_with_rows);
      if (table.head.empty()) continue;
      write_element("head", table.head);
      write(view_words::data);
      const std::uint64_t data = written_;
      move(p.data, p.data + (table.bytes + 2) / 3 * 4);
      write(view_words::end);
      if (left[k] == &places_[k].table) p.table_with_rows = {};
      (left[k] == &places_[k].table ? p.table : p.table_with_rows) = table;
      p.data = data;
    }
    p.begin = begin, p.end = written_;
    kept.push_back(std::move(p));
  }
  places_.swap(kept);
  if (ftruncate(part_.id(), static_cast<off_t>(written_)) != 0) fail_to_write(0);
}

TALUS_INLINE void view_page::finish(const std::string& end) {
  if (!part_.good()) return;
  if (frames_ == 0) write_element("about", "{\"name\":\"talus\"}");
  write_element("end", end);
  for (const char* const piece : view_page_end) write(piece);
  // Another file may have appeared there meanwhile.
  const output_target target = inspect_target(file_, view_output, force_);
  if (!target.objection.empty()) fail<std::runtime_error>("--view {} {}", file_, target.objection);
  if (!part_.rename_to(file_)) {
    const std::string words = words_of_failed_write(file_, 0, errno);
    part_ = {};
    fail<std::runtime_error>("the page {} (--view) cannot be written: {}", file_, words);
  }
}

}  // namespace talus::detail
