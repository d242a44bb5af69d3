#pragma once
// The definitions of checkpoint_course.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cstddef>

#include "talus/io/detail/checkpoint_course.hpp"
#include "talus/io/detail/hdf5_linkage.hpp"

namespace talus::detail {

TALUS_HDF5_INLINE void put_course(const std::vector<course_part>& parts,
                                  std::vector<small_dataset>& out) {
  std::vector<std::uint64_t> numbers;
  for (const course_part& p : parts)
    numbers.insert(numbers.end(), {p.asked, p.taken, p.calls, p.stopped});
  out.push_back(numbers_dataset<std::uint64_t>("/run/course", numbers, 4));
}

TALUS_HDF5_INLINE past_course get_course(const checkpoint_reader& in) {
  if (!in.has("/run/course")) return {};
  const auto numbers = in.integers("/run/course", checkpoint_reader::any, 4);
  std::vector<course_part> parts;
  for (std::size_t k = 0; k + 3 < numbers.size(); k += 4)
    parts.push_back({numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3] != 0});
  return past_course(std::move(parts));
}

TALUS_HDF5_INLINE void put_records(const recorded_values& all, std::vector<small_dataset>& out) {
  std::string names;
  std::vector<double> values;
  for (const recorded_value& r : all.all())
    names += r.name + '\n' + r.dimension + '\n', values.push_back(r.value);
  out.push_back(text_dataset("/recorded/names", names));
  out.push_back(numbers_dataset<double>("/recorded/values", values));
}

/// The lines of a text, each of which ends with a line feed; and an empty one.
[[nodiscard]] inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text)
    if (c == '\n')
      lines.emplace_back();
    else
      lines.back() += c;
  return lines;
}

TALUS_HDF5_INLINE void get_records(const checkpoint_reader& in, recorded_values& all) {
  if (!in.has("/recorded/names")) return;
  const std::vector<std::string> lines = lines_of(in.text("/recorded/names"));
  const auto values = in.reals("/recorded/values", lines.size() / 2);
  std::vector<recorded_value> found;
  for (std::size_t k = 0; k < values.size(); ++k)
    found.push_back({lines[2 * k], lines[2 * k + 1], values[k]});
  all.replace(std::move(found));
}

TALUS_HDF5_INLINE void put_once(const std::vector<once_value>& all,
                                std::vector<small_dataset>& out) {
  std::string names;
  std::vector<std::uint64_t> numbers;
  byte_buffer bytes;
  for (const once_value& v : all) {
    names += v.name + '\n';
    numbers.insert(numbers.end(), {v.bytes.size(), v.fills, v.attempts});
    bytes.insert(bytes.end(), v.bytes.begin(), v.bytes.end());
  }
  out.push_back(text_dataset("/once/names", names));
  out.push_back(numbers_dataset<std::uint64_t>("/once/numbers", numbers, 3));
  out.push_back({"/once/values", number_type::u8, bytes.size(), 1, bytes});
}

TALUS_HDF5_INLINE void get_once(const checkpoint_reader& in, std::vector<once_value>& all) {
  if (!in.has("/once/names")) return;
  const std::vector<std::string> names = lines_of(in.text("/once/names"));
  const auto numbers = in.integers("/once/numbers", names.size() - 1, 3);
  const auto bytes = in.numbers<std::byte>("/once/values", number_type::u8);
  auto from = bytes.begin();
  for (std::size_t k = 0; k + 1 < names.size(); ++k) {
    if (numbers[3 * k] > static_cast<std::uint64_t>(bytes.end() - from))
      fail<std::runtime_error>("is damaged: the value '{}' of world.once is cut off", names[k]);
    const auto to = from + static_cast<std::ptrdiff_t>(numbers[3 * k]);
    auto at = std::find_if(all.begin(), all.end(),
                           [&](const once_value& v) { return v.name == names[k]; });
    if (at == all.end()) at = all.insert(at, once_value{.name = names[k]});
    at->bytes.assign(from, to), from = to;
    at->fills = numbers[3 * k + 1], at->attempts = numbers[3 * k + 2];
  }
}

}  // namespace talus::detail
