#pragma once
// The definitions of settings_file.hpp: compiled once, or by <talus/config.hpp>. Without toml++ the
// reader only says that it is missing.
#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/io/run_signals.hpp"
#include "talus/parallel/launcher.hpp"
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
/// Dots in a key: each may be a table within another, and toml++ calls itself for each.
inline constexpr std::size_t most_dots = 100;

/// Ends the process as that signal would: nothing is open yet.
[[gnu::cold]] inline void end_by(int signal) {
  (void)std::signal(signal, SIG_DFL);
  (void)::raise(signal);
}

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
  if (const int size = find_launcher().size; S_ISFIFO(about.st_mode) && size > 1)
    refuse(compose("it is a pipe, and only one of the {} processes could read it", size));
  std::string text;
  char part[4096];
  for (int waited = 0;;) {
    pollfd writer{id, POLLIN, 0};  // of a pipe: it may come later
    const int ready = ::poll(&writer, 1, 1000);
    if (const int signal = heard_signals().end; signal != 0) end_by(signal);
    if (ready < 0 && errno == EINTR) continue;
    const auto bytes = ::read(id, part, sizeof part);
    if (bytes < 0 && (errno == EINTR || errno == EAGAIN)) continue;  // a writer is there
    if (bytes < 0) refuse(std::strerror(errno));
    if (bytes == 0 && ready == 0 && text.empty()) {
      if (++waited < seconds_for_writer) continue;
      refuse(compose("nobody has opened it to write for {} seconds", seconds_for_writer));
    }
    if (bytes == 0) return text;
    text.append(part, static_cast<std::size_t>(bytes));
    if (text.size() > longest_settings_file) refuse("it is larger than any configuration");
  }
}

#ifdef TALUS_HAS_TOML
/// The place behind a text in quotes that begins at `k`, which may have several lines between three
/// quotes.
[[nodiscard, gnu::cold]] inline std::size_t behind_quotes(std::string_view text, std::size_t k) {
  const char quote = text[k];
  const std::string three(3, quote);
  const bool lines = text.substr(k, 3) == three;
  for (k += lines ? 3 : 1; k < text.size() && (lines || text[k] != '\n'); ++k) {
    if (quote == '"' && text[k] == '\\')
      ++k;
    else if (!lines && text[k] == quote)
      return k + 1;
    else if (lines && text.substr(k, 3) == three)
      return k + 3;
  }
  return std::min(k, text.size());
}

/// Dots in values and comments do not count.
[[gnu::cold]] inline void refuse_deep_names(const std::string& file, std::string_view text) {
  std::size_t dots = 0;
  for (std::size_t k = 0; k < text.size();) {
    const char c = text[k];
    if (c == '"' || c == '\'') {
      k = behind_quotes(text, k);
      continue;
    }
    if (c == '#') k = std::min(text.find('\n', k), text.size() - 1);
    if (text[k] == '\n' || c == '=' || c == ',' || c == '{' || c == '[') dots = 0;
    if (c == '.' && ++dots > most_dots) {
      const auto lines = std::count(text.begin(), text.begin() + static_cast<long>(k), '\n');
      fail<usage_error>("{}:{}: has a key with more than {} dots, and no option has such a name",
                        file, static_cast<std::size_t>(lines) + 1, most_dots);
    }
    ++k;
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

/// Throws usage_error for a list of tables.
[[gnu::cold]] inline void collect_settings(const std::string& file, const toml::table& table,
                                           const std::string& before, std::vector<setting>& all) {
  for (const auto& [key, value] : table) {
    std::string name = before + std::string(key.str());
    if (const auto* inner = value.as_table())
      collect_settings(file, *inner, name + '.', all);
    else if (value.is_array_of_tables())
      fail<usage_error>("{}:{}: [[{}]] begins a list of tables; a program takes one: write [{}]",
                        file, static_cast<std::size_t>(value.source().begin.line), name, name);
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
    collect_settings(file, toml::parse(std::string_view(text)), "", all);
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
