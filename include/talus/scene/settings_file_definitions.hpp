#pragma once
// The definitions of settings_file.hpp: compiled once, or by <talus/config.hpp>. Without toml++ the
// reader only says that it is missing.
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/scene/settings_file.hpp"

#if __has_include(<toml++/toml.h>)
#include <toml++/toml.h>
#define TALUS_HAS_TOML
#endif

namespace talus::detail {

/// A configuration is a page of text: what is longer than this is another file.
inline constexpr std::size_t longest_settings_file = std::size_t{16} << 20;
/// How long a pipe may be without a writer.
inline constexpr int seconds_for_writer = 60;
/// Dots in one line: each may be a table within another, and toml++ calls itself for each.
inline constexpr std::size_t most_dots = 100;

[[nodiscard, gnu::cold]] inline std::string text_of_settings(const std::string& file) {
  const auto refuse = [&](const std::string& why) {
    fail<unreadable_settings>(
        "--config {} cannot be read: {}; give it a file that exists, or leave it out", file, why);
  };
  const int id = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (id < 0) refuse(std::strerror(errno));
  const std::unique_ptr<const int, void (*)(const int*)> close_it(
      &id, [](const int* open) { ::close(*open); });
  struct stat about {};
  if (::fstat(id, &about) != 0) refuse(std::strerror(errno));
  if (S_ISDIR(about.st_mode)) refuse("it is a folder");
  pollfd writer{id, POLLIN, 0};  // of a pipe: it may come later
  int ready = 0;
  do ready = ::poll(&writer, 1, 1000 * seconds_for_writer);
  while (ready < 0 && errno == EINTR);
  if (ready == 0) refuse(compose("nobody has written to it for {} seconds", seconds_for_writer));
  ::fcntl(id, F_SETFL, 0);
  std::string text;
  char part[4096];
  for (;;) {
    const auto bytes = ::read(id, part, sizeof part);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) refuse(std::strerror(errno));
    if (bytes == 0) return text;
    text.append(part, static_cast<std::size_t>(bytes));
    if (text.size() > longest_settings_file) refuse("it is larger than any configuration");
  }
}

#ifdef TALUS_HAS_TOML
[[gnu::cold]] inline void refuse_deep_names(const std::string& file, std::string_view text) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    const auto dots = static_cast<std::size_t>(std::count(line.begin(), line.end(), '.'));
    if (dots > most_dots && !line.starts_with('#'))
      fail<usage_error>("{}:{}: has {} dots in a line, and no name of an option has so many parts",
                        file, number, dots);
    text.remove_prefix(std::min(line.size() + 1, text.size()));
  }
}

[[nodiscard, gnu::cold]] inline setting setting_of(const std::string& key,
                                                   const toml::node& value) {
  setting s;
  s.key = key;
  s.line = value.source().begin.line;
  if (const auto* text = value.as_string()) {
    s.value = text->get();
  } else if (const auto* yes = value.as_boolean()) {
    s.holds = setting::kind::boolean;
    s.value = yes->get() ? "true" : "false";
  } else if (const auto* whole = value.as_integer()) {
    s.holds = setting::kind::number;
    s.value = std::to_string(whole->get());
  } else if (const auto* real = value.as_floating_point()) {
    s.holds = setting::kind::number;
    s.value = detail::text(real->get());
  } else {
    s.holds = setting::kind::other;
    s.value = value.is_array() ? "an array" : "a date or a time";
  }
  return s;
}

[[gnu::cold]] inline void collect_settings(const toml::table& table, const std::string& before,
                                           std::vector<setting>& all) {
  for (const auto& [key, value] : table) {
    std::string name = before + std::string(key.str());
    if (const auto* inner = value.as_table())
      collect_settings(*inner, name + '.', all);
    else
      all.push_back(setting_of(name, value));
  }
}
#endif

TALUS_INLINE void read_settings(const std::string& file,
                                const std::function<void(const setting&)>& take) {
  const std::string text = text_of_settings(file);
#ifdef TALUS_HAS_TOML
  refuse_deep_names(file, text);
  std::vector<setting> all;
  try {
    collect_settings(toml::parse(std::string_view(text)), "", all);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    fail<usage_error>("{}:{}:{}: is no TOML: {}", file, static_cast<std::size_t>(at.line),
                      static_cast<std::size_t>(at.column), std::string(error.description()));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const setting& a, const setting& b) { return a.line < b.line; });
  for (const setting& s : all) take(s);
#else
  (void)take;
  fail<usage_error>(
      "--config {} cannot be read: talus was compiled without toml++; install it (in Debian "
      "libtomlplusplus-dev) and build talus again, or use --set",
      file);
#endif
}

}  // namespace talus::detail
