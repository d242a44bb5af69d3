#pragma once
// The names of the files of --output, and existing files at the place of a series of numbered
// files.
#include <dirent.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

#include "talus/core/output_file.hpp"

namespace talus::detail {

inline constexpr const char* vtk_extension = ".hdf";
/// Ends of the names of the series of --output: bodies, contacts, joints and surfaces.
inline constexpr const char* ends_of_output[] = {"", "_contacts", "_joints", "_surfaces"};

/// The name without the extension of an output.
[[nodiscard, gnu::cold]] inline std::string output_name(std::string name) {
  for (const std::string_view end : {std::string_view(".series"), std::string_view(vtk_extension)})
    if (name.size() > end.size() && std::string_view(name).substr(name.size() - end.size()) == end)
      name.erase(name.size() - end.size());
  return name;
}
/// The index of a series of --output.
[[nodiscard, gnu::cold]] inline std::string index_of_output(const std::string& name,
                                                            std::string_view end) {
  return name + std::string(end) + vtk_extension + ".series";
}

/// Checks all files BEGIN<digits>END; `begin` contains the folder. Throws runtime_error, with
/// `what` before the file, if one must not be replaced. Returns how many would be replaced. Files
/// with `known` true for their names without the folder may be replaced.
template <class Known>
[[nodiscard, gnu::cold]] std::size_t inspect_series(const char* what, const std::string& begin,
                                                    std::string_view end, const output_kind& kind,
                                                    bool force, Known&& known) {
  const auto slash = begin.find_last_of('/');
  const std::string folder = slash == begin.npos ? "" : begin.substr(0, slash + 1);
  const std::string first = begin.substr(slash + 1);
  DIR* const all = ::opendir(folder.empty() ? "." : folder.c_str());
  std::size_t found = 0;
  std::string objection;
  while (const dirent* const one = all != nullptr ? ::readdir(all) : nullptr) {
    const std::string_view name = one->d_name;
    if (!name.starts_with(first) || !name.ends_with(end) ||
        name.size() <= first.size() + end.size() ||
        name.substr(first.size(), name.size() - first.size() - end.size())
                .find_first_not_of("0123456789") != name.npos)
      continue;
    const std::string file = folder + std::string(name);
    const output_target target = inspect_target(file, kind, force || known(std::string(name)));
    if (!target.objection.empty() && objection.empty())
      objection = std::string(what) + " " + file + " " + target.objection;
    found += target.replaces;
  }
  if (all != nullptr) ::closedir(all);
  if (!objection.empty()) throw std::runtime_error(objection);
  return found;
}

}  // namespace talus::detail
