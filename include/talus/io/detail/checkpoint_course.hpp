#pragma once
// The calls of simulate(), and the user-defined columns of the table, in a checkpoint.
#include <cstdint>
#include <string>
#include <vector>

#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/file_kind.hpp"
#include "talus/state/course.hpp"
#include "talus/state/recorded_values.hpp"

namespace talus::detail {

[[gnu::cold]] inline void put_course(const std::vector<course_part>& parts,
                                     std::vector<small_dataset>& out) {
  std::vector<std::uint64_t> numbers;
  for (const course_part& p : parts)
    numbers.insert(numbers.end(), {p.asked, p.taken, p.calls, p.stopped});
  out.push_back(numbers_dataset<std::uint64_t>("/run/course", numbers, 4));
}
/// Empty for a file of the first versions, which lack it.
[[nodiscard, gnu::cold]] inline past_course get_course(const checkpoint_reader& in) {
  if (!in.has("/run/course")) return {};
  const auto numbers = in.integers("/run/course", checkpoint_reader::any, 4);
  std::vector<course_part> parts;
  for (std::size_t k = 0; k + 3 < numbers.size(); k += 4)
    parts.push_back({numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3] != 0});
  return past_course(std::move(parts));
}

/// Names and dimensions in lines, and the values.
[[gnu::cold]] inline void put_records(const recorded_values& all, std::vector<small_dataset>& out) {
  std::string names;
  std::vector<double> values;
  for (const recorded_value& r : all.all())
    names += r.name + '\n' + r.dimension + '\n', values.push_back(r.value);
  out.push_back(text_dataset("/recorded/names", names));
  out.push_back(numbers_dataset<double>("/recorded/values", values));
}
[[gnu::cold]] inline void get_records(const checkpoint_reader& in, recorded_values& all) {
  if (!in.has("/recorded/names")) return;
  const std::string names = in.text("/recorded/names");
  std::vector<std::string> lines(1);
  for (const char c : names)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  const auto values = in.reals("/recorded/values", lines.size() / 2);
  std::vector<recorded_value> found;
  for (std::size_t k = 0; k < values.size(); ++k)
    found.push_back({lines[2 * k], lines[2 * k + 1], values[k]});
  all.replace(std::move(found));
}

}  // namespace talus::detail
