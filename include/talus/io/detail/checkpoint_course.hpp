#pragma once
// The calls of simulate(), what was computed once between them, and the user-defined columns of the
// table, in a checkpoint.
#include <cstdint>
#include <string>
#include <vector>

#include "talus/io/detail/checkpoint_reader.hpp"
#include "talus/io/detail/file_kind.hpp"
#include "talus/state/course.hpp"
#include "talus/state/recorded_values.hpp"
#include "talus/world/checkpoints.hpp"

namespace talus::detail {

[[gnu::cold]] void put_course(const std::vector<course_part>& parts,
                              std::vector<small_dataset>& out);
/// Empty for a file of the first versions, which lack it.
[[nodiscard, gnu::cold]] past_course get_course(const checkpoint_reader& in);

/// Names and dimensions in lines, and the values.
[[gnu::cold]] void put_records(const recorded_values& all, std::vector<small_dataset>& out);
[[gnu::cold]] void get_records(const checkpoint_reader& in, recorded_values& all);

/// Names in lines, of each value its number of bytes and the counters after it, and the bytes.
[[gnu::cold]] void put_once(const std::vector<once_value>& all, std::vector<small_dataset>& out);
/// Replaces those of the same name.
[[gnu::cold]] void get_once(const checkpoint_reader& in, std::vector<once_value>& all);

}  // namespace talus::detail

#ifndef TALUS_COMPILED_HDF5
#include "talus/io/detail/checkpoint_course_definitions.hpp"
#endif
