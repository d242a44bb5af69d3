#pragma once
// The definitions of checkpoint_course.hpp, in the compiled part or in each program.
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

TALUS_HDF5_INLINE void get_records(const checkpoint_reader& in, recorded_values& all) {
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
