#pragma once
// Definitions of scene/command_line.hpp: options from files and from --set, and all options as such
// a file.
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/scene/command_line.hpp"

namespace talus {

TALUS_INLINE std::string command_line::read_file(const std::string& file) {
  if (reader_ == nullptr)
    return detail::compose(
        "--config {}: this program is built from headers alone and reads no files of options: link "
        "talus::compiled, or #include <talus/config.hpp>, which needs toml++ (in Debian "
        "libtomlplusplus-dev)",
        file);
  ++files_;
  std::string mistake;
  reader_(file, [&](const setting& s) {
    if (mistake.empty()) mistake = read_setting(file, s);
  });
  return mistake;
}

TALUS_INLINE std::string command_line::read_setting(const std::string& file, const setting& s) {
  const std::string place = detail::compose("{}:{}", file, s.line);
  option* const o = find_key(s.key);
  if (o == nullptr) return place + ": " + unknown(s.key, true);
  const std::string name = place + ": " + s.key;
  if (o->holds == kind::file || o->holds == kind::pair)
    return detail::compose("{}: {} stands on the command line only, not in a file", place, s.key);
  if (o->files == files_)
    return detail::compose("{} is set twice in this file, first at {}", name, o->place);
  const bool text = s.holds == setting::kind::text;
  // Whole numbers that TOML cannot hold are written as texts.
  const bool large = o->holds == kind::natural && text && s.value.size() > 18;
  const char* wanted = o->holds == kind::text ? (text ? nullptr : "a text in quotes")
                       : o->holds == kind::flag
                           ? (s.holds == setting::kind::boolean ? nullptr : "true or false")
                       : s.holds == setting::kind::number || large ? nullptr
                                                                   : "a number";
  if (wanted != nullptr)
    return detail::compose("{} needs {}{}, but is {}; see --help", name, wanted,
                           o->limits.empty() ? "" : ", " + o->limits,
                           text ? '"' + s.value + '"' : s.value);
  std::string wrong = o->refusal.empty() ? read(*o, s.value, name) : place + ": " + o->refusal;
  o->from = origin::file;
  o->files = files_;
  o->place = place;
  return wrong;
}

TALUS_INLINE std::string command_line::read_pair(std::string_view pair) {
  const std::string_view key = pair.substr(0, pair.find('='));
  if (key.empty() || key.size() == pair.size())
    return detail::compose("--set needs NAME=VALUE, as in --set steps=200, but is '{}'; see --help",
                           std::string(pair));
  option* const o = find_key(key);
  if (o == nullptr) return "--set: " + unknown(key, true);
  if (o->holds == kind::file || o->holds == kind::pair)
    return detail::compose("--set cannot set {}: give it by itself", o->name);
  return read_value(*o, origin::set, pair.substr(key.size() + 1));
}

/// The present value as TOML; empty if it stands for "not given".
TALUS_INLINE std::string command_line::value_text(const option& o) {
  if (o.holds == kind::flag) return *static_cast<const bool*>(o.target) ? "true" : "false";
  if (o.holds == kind::text) {
    const std::string& text = *static_cast<const std::string*>(o.target);
    return text.empty() && o.initial.empty() ? "" : detail::quoted_text(text);
  }
  const number value = o.load(o.target);
  if (!(value >= o.lower && value <= o.upper)) return {};
  std::string digits = print(value, o.holds);
  const bool large = o.holds == kind::natural &&
                     value > static_cast<number>(std::numeric_limits<std::int64_t>::max());
  return large ? '"' + digits + '"' : digits;
}

TALUS_INLINE std::string command_line::configuration() const {
  std::string text;
  for (const option& o : options_) {
    if (!o.refusal.empty() || o.target == nullptr) continue;
    std::string key = o.name.substr(2);
    for (const char c : key)
      if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
            c == '-' || c == '_' || c == '.')) {
        key = '"' + key + '"';
        break;
      }
    const std::string value = value_text(o);
    if (value.empty()) {
      text += "# " + key + ": not given\n";
      continue;
    }
    std::string from = o.from == origin::none   ? "default"
                       : o.from == origin::file ? o.place
                       : o.from == origin::set  ? "--set"
                                                : "command line";
    for (char& c : from)
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    text += key + " = " + value + "  # " + from + "\n";
  }
  return text;
}

}  // namespace talus
