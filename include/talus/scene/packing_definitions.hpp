#pragma once
// The definitions of packing.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/input_file.hpp"
#include "talus/core/linkage.hpp"
#include "talus/core/output_file.hpp"
#include "talus/scene/packing.hpp"

namespace talus {

namespace detail {

/// Where the text in double quotes that begins at `at` ends: behind the quote that closes it,
/// before a separator or the end of the line. Two quotes within it stand for one. `at` if none
/// closes it.
[[nodiscard, gnu::cold]] TALUS_INLINE std::size_t end_of_quotes(const std::string& line,
                                                                std::size_t at, char separator) {
  for (std::size_t k = line.find('"', at + 1); k != line.npos; k = line.find('"', k + 1)) {
    if (k + 1 < line.size() && line[k + 1] == '"') {
      ++k;
      continue;
    }
    std::size_t after = k + 1;
    while (after < line.size() && line[after] == ' ' && separator != ' ') ++after;
    return after == line.size() || line[after] == separator ? k + 1 : at;
  }
  return at;
}

/// The next separator of a line that is not within double quotes, or the size of the line.
[[nodiscard, gnu::cold]] TALUS_INLINE std::size_t end_of_field(const std::string& line,
                                                               std::size_t at, char separator) {
  const std::size_t first = line.find_first_not_of(separator == '\t' ? " " : " \t", at);
  if (first != line.npos && line[first] == '"') at = end_of_quotes(line, first, separator);
  return std::min(line.find(separator, at), line.size());
}

/// The fields of a line, without the blanks and quotes around them. A blank as separator stands for
/// any number of blanks.
[[nodiscard, gnu::cold]] TALUS_INLINE std::vector<std::string> fields_of(const std::string& line,
                                                                         char separator) {
  std::vector<std::string> fields;
  const std::string blanks = separator == '\t' ? " " : " \t";
  const auto trim = [&](const std::string& text) {
    const auto first = text.find_first_not_of(blanks), last = text.find_last_not_of(blanks);
    return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
  };
  std::string rest = trim(line);
  if (separator == ' ') std::replace(rest.begin(), rest.end(), '\t', ' ');
  for (std::size_t at = 0; at <= rest.size();) {
    const std::size_t end = end_of_field(rest, at, separator);
    std::string field = trim(rest.substr(at, end - at));
    if (field.size() > 1 && (field.front() == '"' || field.front() == '\'') &&
        field.back() == field.front())
      field = trim(field.substr(1, field.size() - 2));
    if (separator != ' ' || !field.empty()) fields.push_back(std::move(field));
    at = end + 1;
  }
  return fields;
}

/// The separator of a table by its first line.
[[nodiscard, gnu::cold]] TALUS_INLINE char separator_of(const std::string& names) {
  for (const char c : {',', ';', '\t'})
    for (std::size_t at = 0; at < names.size(); ++at)
      if ((at = end_of_field(names, at, c)) < names.size() &&
          std::count(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(at), '"') % 2 == 0)
        return c;
  return fields_of(names, '|').size() > 3 ? '|' : ' ';  // |v| may be the name of a column
}

[[nodiscard, gnu::cold]] TALUS_INLINE const char* word_of(char separator) {
  return separator == ','    ? "commas"
         : separator == ';'  ? "semicolons"
         : separator == '\t' ? "tabs"
         : separator == '|'  ? "bars"
                             : "blanks";
}
/// The name of a column such as "x [mm]".
[[nodiscard, gnu::cold]] TALUS_INLINE std::string without_unit(const std::string& head) {
  const auto at = head.find(" [");
  return at == std::string::npos || head.back() != ']' ? head : head.substr(0, at);
}

[[nodiscard, gnu::cold]] TALUS_INLINE std::string in_lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace detail

[[gnu::cold]] TALUS_INLINE packing read_packing(const std::string& file) {
  if (detail::is_folder(file))
    detail::fail<std::runtime_error>("the packing {} is a folder: name the file in it", file);
  std::ifstream in(file);
  if (!in) detail::fail<std::runtime_error>("the packing {} cannot be read", file);
  const auto refuse = [&](std::size_t line, const std::string& what) {
    detail::fail<std::runtime_error>("{}, line {}: {}", file, line, what);
  };
  static constexpr const char* names[] = {"x", "y", "z", "r", "vx", "vy", "vz"};
  constexpr std::size_t none = ~std::size_t{0};
  std::size_t column[7] = {none, none, none, none, none, none, none}, columns = 0;
  char separator = ',';
  detail::plain_vector<packed_sphere> spheres;
  std::string line;
  const auto next = [&] {
    try {
      return detail::read_line(in, line);
    } catch (const std::exception& e) {
      detail::fail<std::runtime_error>("the packing {} cannot be read: {}", file, e.what());
    }
  };
  for (std::size_t number = 1; next(); ++number) {
    if (number == 1 && line.starts_with(detail::byte_order_mark))
      line.erase(0, detail::byte_order_mark.size());
    if (number == 1 && (line.starts_with("\xff\xfe") || line.starts_with("\xfe\xff")))
      detail::fail<std::runtime_error>("the packing {} is in UTF-16: save it as UTF-8", file);
    if (line.find_first_not_of(" \t") == std::string::npos || line[0] == '#') continue;
    if (columns == 0) separator = detail::separator_of(line);
    const auto fields = detail::fields_of(line, separator);
    if (columns == 0) {
      columns = fields.size();
      for (std::size_t c = 0; c < columns; ++c)
        for (std::size_t k = 0; k < 7; ++k)
          if (detail::in_lower_case(detail::without_unit(fields[c])) == names[k]) {
            if (column[k] != none)
              refuse(number, detail::compose("the column {} is there twice", names[k]));
            column[k] = c;
          }
      for (std::size_t k = 0; k < 4; ++k)
        if (column[k] == none)
          refuse(number,
                 detail::compose("there is no column {} among the {} of the first line, which "
                                 "names them, of which x, y, z and r are needed, with {} "
                                 "between them",
                                 names[k], columns, detail::word_of(separator)));
      continue;
    }
    if (fields.size() != columns)
      refuse(number,
             detail::compose("it has {} fields, with {} between them, and the first line {} "
                             "columns",
                             fields.size(), detail::word_of(separator), columns));
    real value[7] = {};
    for (std::size_t k = 0; k < 7; ++k) {
      if (column[k] == none) continue;
      const std::string& text = fields[column[k]];
      char* end = nullptr;
      value[k] = std::strtod(text.c_str(), &end);
      if (text.empty() || *end != 0 || !std::isfinite(value[k]))
        refuse(number,
               detail::compose(
                   "{} is '{}', which is no finite number{}", names[k], text,
                   text.find(',') == std::string::npos ? "" : ": decimals stand behind a point"));
    }
    if (!(value[3] > 0))
      refuse(number, detail::compose("the radius r is {}, and must be positive", value[3]));
    spheres.push_back(
        {vec3(value[0], value[1], value[2]), value[3], vec3(value[4], value[5], value[6])});
  }
  if (columns == 0)
    detail::fail<std::runtime_error>(
        "the packing {} is empty: its first line names the columns x, y, z and r", file);
  return packing(std::move(spheres));
}

[[gnu::cold]] TALUS_INLINE std::string detail::write_spheres(const std::string& file,
                                                             plain_vector<sent_sphere> spheres) {
  static constexpr std::string_view head = "x,y,z,r,vx,vy,vz\n";
  static constexpr output_kind kind{
      "a packing of talus", [](std::string_view found) { return found.starts_with(head); }, false};
  std::sort(spheres.begin(), spheres.end(),
            [](const sent_sphere& a, const sent_sphere& b) { return a.id < b.id; });
  std::string text(head);
  for (const sent_sphere& one : spheres)
    for (std::size_t k = 0; k < 7; ++k) {
      char number[32];
      std::snprintf(number, sizeof number, "%.17g%c", one.values[k], k < 6 ? ',' : '\n');
      text += number;
    }
  try {
    write_output(file, text, kind, false);
  } catch (const std::exception& e) {
    return e.what();
  }
  return {};
}

}  // namespace talus
