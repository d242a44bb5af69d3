#pragma once
// Files of --config. They are read by toml++, which is compiled once, in talus::compiled; a program
// of headers alone includes <talus/config.hpp>.
#include <functional>
#include <string>

#include "talus/scene/command_line.hpp"

namespace talus {

namespace detail {

/// A settings_reader for TOML. Throws usage_error with file and line if the file cannot be read or
/// is no TOML.
[[gnu::cold]] void read_settings(const std::string& file,
                                 const std::function<void(const setting&)>& take);

/// The reader of a program of headers alone; defined by <talus/config.hpp>.
template <class Options>
struct settings_file;

}  // namespace detail

}  // namespace talus
