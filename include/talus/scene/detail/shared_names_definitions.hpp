#pragma once
// The definitions of shared_names.hpp, in the compiled part or in each program.
#include <cstdlib>
#include <string_view>
#include <vector>

#include "talus/core/linkage.hpp"
#include "talus/core/output_file.hpp"
#include "talus/io/output_series.hpp"
#include "talus/scene/detail/shared_names.hpp"

namespace talus::detail {

/// The path without the parts "." and without doubled slashes.
[[nodiscard, gnu::cold]] inline std::string plain_path(std::string_view path) {
  std::string plain = path.starts_with('/') ? "/" : "";
  while (!path.empty()) {
    const auto slash = path.find('/');
    const std::string_view part = path.substr(0, slash);
    path.remove_prefix(slash == path.npos ? path.size() : slash + 1);
    if (part.empty() || part == ".") continue;
    if (!plain.empty() && plain.back() != '/') plain += '/';
    plain += part;
  }
  return plain;
}

/// The path of a file, which is one whether it is named from the working folder or not, and through
/// links of folders that exist.
[[nodiscard, gnu::cold]] inline std::string place_of(const std::string& path) {
  const std::string plain = plain_path(path);
  const auto slash = plain.find_last_of('/');
  const std::string folder = slash == plain.npos ? "." : plain.substr(0, slash + 1);
  const std::string name = slash == plain.npos ? plain : plain.substr(slash + 1);
  char* const found = ::realpath(folder.c_str(), nullptr);
  if (found != nullptr && name != "..") {
    std::string place = found;
    std::free(found);
    return plain_path(place + '/' + name);
  }
  std::free(found);
  char* const here = plain.starts_with('/') ? nullptr : ::realpath(".", nullptr);
  const std::string from = here == nullptr ? "" : here;
  std::free(here);
  return plain_path(from + '/' + plain);
}

/// A file that a run writes for an option, or with `end` the files BEGIN<digits>END.
struct written_file {
  const char* meaning;  ///< as in "the lock of"
  std::string begin, end{};

  [[nodiscard]] bool is(std::string_view path) const {
    if (end.empty()) return path == begin;
    return path.size() > begin.size() + end.size() && path.starts_with(begin) &&
           path.ends_with(end) &&
           path.substr(begin.size(), path.size() - begin.size() - end.size())
                   .find_first_not_of("0123456789") == path.npos;
  }
};

/// What a run writes beside the file that an option names.
[[nodiscard, gnu::cold]] inline std::vector<written_file> written_beside(const named_file& file) {
  std::vector<written_file> all;
  const std::string path = place_of(file.value), &option = file.option;
  if (option == "--restart") return all;
  if (option != "--checkpoint" && option != "--log") {
    all.push_back({"the configuration beside", path + ".config.toml"});
    all.push_back({"the lock of the configuration beside", path + ".config.toml.lock"});
  }
  if (option == "--frames") {
    all.push_back({"the lock of", place_of(file.value + "/frame.pov.series.lock")});
    all.push_back({"a picture of", place_of(file.value + "/frame_"), ".pov"});
  } else if (option == "--output") {
    for (const char* const end : ends_of_output) {
      const std::string index = index_of_output(output_name(path), end);
      all.push_back({"an index of", index});
      all.push_back({"the lock of", index + ".lock"});
      all.push_back({"a file of", output_name(path) + end + "_", vtk_extension});
    }
  } else {
    all.push_back({"the lock of", path + ".lock"});
  }
  return all;
}

TALUS_INLINE void refuse_shared_names(std::span<const named_file> files) {
  const auto unnamed = [](const named_file& f) { return f.value.empty() || is_stream(f.value); };
  for (const named_file& a : files) {
    if (unnamed(a) || a.option == "--output") continue;  // its value is the name of no file
    const std::string path = place_of(a.value);
    for (const named_file& b : files) {
      if (&a == &b || unnamed(b)) continue;
      const bool pair = (a.option == "--checkpoint" && b.option == "--restart") ||
                        (a.option == "--restart" && b.option == "--checkpoint");
      if (!pair && &a < &b && b.option != "--output" && path == place_of(b.value))
        throw usage_error(compose("{} and {} name the same file, {}: give each its own", a.option,
                                  b.option, a.value));
      for (const written_file& beside : written_beside(b))
        if (beside.is(path))
          throw usage_error(compose("{} {} is the name of {} {}: give it another one", a.option,
                                    a.value, beside.meaning, b.option));
    }
  }
}

}  // namespace talus::detail
