#pragma once
// Reads the files of --config in a program of headers alone. Programs that link talus::compiled
// read them without this header. Needs toml++.
#include "talus/scene/settings_file.hpp"

#ifndef TALUS_COMPILED
#if !__has_include(<toml++/toml.h>)
#error "<talus/config.hpp> needs toml++: install it (in Debian libtomlplusplus-dev)"
#endif
#include "talus/scene/settings_file_definitions.hpp"

namespace talus::detail {

template <class Options>
struct settings_file {
  static void read(const std::string& file, const std::function<void(const setting&)>& take) {
    read_settings(file, take);
  }
};

}  // namespace talus::detail
#endif
