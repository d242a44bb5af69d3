#pragma once
// What the benchmark programs share besides the scenes: options, CPU time, one flat JSON object.
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "talus/core/output_file.hpp"

namespace bench {

/// Files of a benchmark: results, which replace other files of JSON, and states for itself.
inline constexpr talus::detail::output_kind json_output{
    "a file of JSON",
    [](std::string_view head) {
      const auto at = head.find_first_not_of(" \n\r\t");
      return at != head.npos && (head[at] == '[' || head[at] == '{');
    },
    false};
inline constexpr talus::detail::output_kind state_output{
    "a state of a benchmark", [](std::string_view) { return true; }, false};

/// Throws for a file that must not be replaced, or cannot be written, before anything is measured.
inline void require_place(const std::string& file, const talus::detail::output_kind& kind) {
  if (file.empty()) throw std::invalid_argument("a file needs a name, but that is empty");
  if (talus::detail::is_stream(file)) return;
  const auto target = talus::detail::inspect_target(file, kind, false);
  if (!target.objection.empty()) throw std::runtime_error(file + " " + target.objection);
  if (!talus::detail::part_file(file).good())
    throw std::runtime_error(
        file + " cannot be written: " + talus::detail::words_of_failed_write(file, 0, errno));
}

/// Writes a whole file by the one way of outputs.
inline void write_file(const std::string& text, const std::string& file,
                       const talus::detail::output_kind& kind) {
  const talus::detail::ignored_signal size(SIGXFSZ), pipe(SIGPIPE);
  try {
    talus::detail::write_output(file, text, kind, false);
  } catch (const std::exception& e) {
    throw std::runtime_error(file + " " + e.what());
  }
}

/// CPU seconds of all threads of this process so far.
inline double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// CPU time of single steps, for a mean (the cost) and a median (robust on a shared machine).
class stopwatch {
 public:
  template <class F>
  void time(F&& f) {
    const double start = cpu_seconds();
    f();
    ms_.push_back(1e3 * (cpu_seconds() - start));
  }
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (const double x : ms_) sum += x;
    return ms_.empty() ? 0 : sum / static_cast<double>(ms_.size());
  }
  [[nodiscard]] double median() const { return quantile(0.5); }
  [[nodiscard]] double fastest() const { return quantile(0); }
  [[nodiscard]] double p99() const { return quantile(0.99); }
  [[nodiscard]] double longest() const { return quantile(1); }

 private:
  [[nodiscard]] double quantile(double q) const {
    if (ms_.empty()) return 0;
    auto sorted = ms_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
  }
  std::vector<double> ms_;
};

/// `--name value` options: ask for each with its default, then `done()` rejects what nobody asked
/// for.
class arguments {
 public:
  arguments(int argc, char** argv) : given_(argv + 1, argv + argc) {}

  std::string text(const std::string& name, const std::string& fallback) {
    help_ += "  --" + name + "  (" + (fallback.empty() ? "none" : fallback) + ")\n";
    const auto it = std::find(given_.begin(), given_.end(), "--" + name);
    if (it == given_.end()) return fallback;
    if (it + 1 == given_.end()) throw std::invalid_argument("--" + name + " needs a value");
    const std::string value = *(it + 1);
    given_.erase(it, it + 2);
    return value;
  }

  /// The file of --json, empty unless it is given. Throws for one that must not be replaced.
  std::string json_file() {
    const bool given = std::find(given_.begin(), given_.end(), "--json") != given_.end();
    std::string file = text("json", "");
    if (given) require_place(file, json_output);
    return file;
  }

  std::uint64_t count(const std::string& name, std::uint64_t fallback) {
    const std::string value = text(name, std::to_string(fallback));
    if (value.empty() || value.size() > 18 || value.find_first_not_of("0123456789") != value.npos)
      throw std::invalid_argument("--" + name + " needs a whole number, not '" + value + "'");
    return std::stoull(value);
  }

  /// Whole numbers between commas.
  std::vector<int> counts(const std::string& name, const std::string& fallback) {
    const std::string value = text(name, fallback);
    std::vector<int> all;
    for (std::size_t at = 0; at <= value.size();) {
      const std::size_t end = std::min(value.find(',', at), value.size());
      const std::string one = value.substr(at, end - at);
      if (one.empty() || one.size() > 9 || one.find_first_not_of("0123456789") != one.npos)
        throw std::invalid_argument("--" + name + " needs whole numbers between commas, not '" +
                                    value + "'");
      all.push_back(std::stoi(one));
      at = end + 1;
    }
    return all;
  }

  /// False when help was asked for and printed; throws for anything left over.
  bool done() const {
    if (given_.empty()) return true;
    if (given_.front() != "--help")
      throw std::invalid_argument("unknown option '" + given_.front() + "'; the options are\n" +
                                  help_);
    std::cout << help_;
    return false;
  }

 private:
  std::vector<std::string> given_;
  std::string help_;
};

/// A flat JSON object; keys keep the order in which they were added.
class record {
 public:
  template <class Value>
  void add(const std::string& key, const Value& value) {
    if constexpr (std::is_same_v<Value, bool>) {
      fields_.emplace_back(key, value ? "true" : "false");
    } else if constexpr (std::is_integral_v<Value>) {
      fields_.emplace_back(key, std::to_string(value));
    } else if constexpr (std::is_floating_point_v<Value>) {
      char text[32];
      std::snprintf(text, sizeof text, "%.6g", static_cast<double>(value));
      fields_.emplace_back(key, std::isfinite(value) ? text : "null");
    } else {
      std::string text = "\"";
      for (const char c : std::string(value)) {
        if (c == '"' || c == '\\') text += '\\';
        text += c;
      }
      fields_.emplace_back(key, text + '"');
    }
  }

  [[nodiscard]] std::string json() const {
    std::string text = "{";
    for (const auto& [key, value] : fields_)
      text += (text.size() > 1 ? ",\n  \"" : "\n  \"") + key + "\": " + value;
    return text + "\n}\n";
  }

  /// Writes to the file, or to standard output when its name is empty.
  void write(const std::string& file) const { write_text(json(), file); }

  static void write_text(const std::string& text, const std::string& file) {
    if (!file.empty()) return write_file(text, file, json_output);
    if (!(std::cout << text << std::flush))
      throw std::runtime_error("standard output cannot be written: let it go where there is room");
  }

 private:
  std::vector<std::pair<std::string, std::string>> fields_;
};

}  // namespace bench
