#pragma once
// Options of one run that name the same file, or a file that the run writes beside another one.
#include <span>
#include <string>

#include "talus/scene/command_line.hpp"

namespace talus::detail {

/// An option that names a file, and its value; empty if it is not given.
struct named_file {
  std::string option, value;
};

/// Throws usage_error if one of these files is also written for another option: as its file, as
/// the configuration or the lock beside it, or as one of a series. --restart may name the file of
/// --checkpoint.
[[gnu::cold]] void refuse_shared_names(std::span<const named_file> files);

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/scene/detail/shared_names_definitions.hpp"
#endif
