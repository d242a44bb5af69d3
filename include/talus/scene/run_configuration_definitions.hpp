#pragma once
// The definitions of run_configuration.hpp, in the compiled part or in each program.
#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

#include "talus/core/linkage.hpp"
#include "talus/scene/run_configuration.hpp"
#include "talus/scene/run_outputs.hpp"

namespace talus::detail {

template <class F>
void run_configuration::each_file(F&& f) const {
  const std::string* const outputs[] = {&options_->json, &options_->csv, &options_->output,
                                        &options_->frames, &options_->view};
  constexpr const char* names[] = {"--json", "--csv", "--output", "--frames", "--view"};
  for (std::size_t k = 0; k < std::size(names); ++k) {
    std::string path = *outputs[k];
    if (path.empty() || is_stream(path)) continue;
    while (path.size() > 1 && path.back() == '/') path.pop_back();
    f(names[k], path + ".config.toml");
  }
}

TALUS_INLINE void run_configuration::prepare(const options& o, const std::string& program) {
  options_ = &o;
  text_ =
      std::string(configuration_mark_line) + program +
      "\n# Each line is an option with its value; its comment says where the value comes from.\n"
      "# --config with this file makes the run again.\n" +
      o.configuration;
  each_file([&](const char* name, const std::string& path) {
    (void)inspect_output((std::string("the configuration beside ") + name).c_str(), path,
                         configuration_output, o.force);
    const auto locked = [&](const run_lock& lock) { return lock.is_of(path); };
    if (std::none_of(locks_.begin(), locks_.end(), locked))  // --json X and --output X share one
      locks_.emplace_back(path, compose("the configuration {} (beside {})", path, name));
  });
}

TALUS_INLINE void run_configuration::write() {
  if (options_ == nullptr) return;
  each_file([&](const char* name, const std::string& path) {
    try {
      write_output(path, text_, configuration_output, options_->force);
    } catch (const std::exception& e) {
      fail<std::runtime_error>("the configuration {} (beside {}) {}", path, name, e.what());
    }
  });
  options_ = nullptr;
}

/// FNV-1a (Fowler, Noll, Vo), cut to the digits of a double.
TALUS_INLINE double configuration_mark(const std::string& configuration) {
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : configuration) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  return static_cast<double>(hash >> 12);
}

/// One line of a configuration: its option and the value, without the comment.
struct configured_option {
  std::string_view key, value;
};

[[nodiscard, gnu::cold]] inline configured_option option_in(std::string_view line) {
  constexpr std::string_view none = ": not given";
  if (line.starts_with("# ") && line.ends_with(none)) {
    line.remove_prefix(2);
    return {line.substr(0, line.size() - none.size()), "not given"};
  }
  const auto equals = line.find(" = "), comment = line.rfind("  # ");
  if (equals == line.npos || comment == line.npos || comment < equals + 3) return {};
  return {line.substr(0, equals), line.substr(equals + 3, comment - equals - 3)};
}

[[nodiscard, gnu::cold]] inline std::string_view value_in(std::string_view configuration,
                                                          std::string_view key) {
  while (!configuration.empty()) {
    const auto end = configuration.find('\n');
    const configured_option one = option_in(configuration.substr(0, end));
    if (one.key == key) return one.value;
    configuration.remove_prefix(end == configuration.npos ? configuration.size() : end + 1);
  }
  return {};
}

TALUS_INLINE std::string differing_options(const std::string& mine, const std::string& theirs) {
  command_line usual("");
  options usual_options;
  usual_options.describe(usual);
  const std::string of_talus = usual.configuration();
  std::string words;
  std::string_view rest = mine;
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    const configured_option one = option_in(rest.substr(0, end));
    rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
    if (one.key.empty() || !value_in(of_talus, one.key).empty()) continue;
    const std::string_view was = value_in(theirs, one.key);
    if (was.empty() || was == one.value) continue;
    if (!words.empty()) words += ", ";
    words += compose("{} is {} and was {}", std::string(one.key), std::string(one.value),
                     std::string(was));
  }
  return words;
}

}  // namespace talus::detail
