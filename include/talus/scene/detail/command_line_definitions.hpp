#pragma once
// Definitions of scene/command_line.hpp.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "talus/core/error.hpp"
#include "talus/core/linkage.hpp"
#include "talus/core/shown_text.hpp"
#include "talus/scene/command_line.hpp"

namespace talus {

TALUS_INLINE void command_line::add_option(std::string_view name, std::string_view meaning,
                                           kind holds, void* target) {
  if (!name.starts_with("--") || name.size() < 3 || name.find_first_of("= ") != name.npos)
    detail::fail<std::invalid_argument>("the option '{}' needs a name like --spheres",
                                        std::string(name));
  if (name == "--help" || find(name) != nullptr)
    detail::fail<std::invalid_argument>("the option {} is described twice", std::string(name));
  option& o = options_.emplace_back();
  o.name = name;
  o.meaning = meaning;
  o.holds = holds;
  o.target = target;
  if (holds == kind::text) o.initial = *static_cast<std::string*>(target);
}

TALUS_INLINE void command_line::add_number(std::string_view name, std::string_view meaning,
                                           kind holds, void* target, number initial,
                                           void (*store)(void*, number),
                                           number (*load)(const void*), number least, number most) {
  add_option(name, meaning, holds, target);
  option& o = options_.back();
  o.initial = print(initial, holds);
  o.store = store;
  o.load = load;
  o.lower = o.least = least;
  o.upper = o.most = most;
}

TALUS_INLINE void command_line::limit(number lower, number upper, number initial) {
  option& o = options_.back();
  o.limits = upper == o.most ? detail::compose("at least {}", print(lower, o.holds))
                             : detail::compose("between {} and {}", print(lower, o.holds),
                                               print(upper, o.holds));
  o.lower = lower;
  o.upper = upper;
  if (!(initial >= lower && initial <= upper)) o.initial.clear();
}

TALUS_INLINE void command_line::limit_to_positive() {
  options_.back().limits = "positive";
  options_.back().lower = std::numeric_limits<double>::denorm_min();
}

TALUS_INLINE void command_line::add_rest(std::string_view name, std::vector<std::string>& values,
                                         std::string_view meaning) {
  rest_ = &values;
  rest_name_ = name;
  rest_meaning_ = meaning;
}

TALUS_INLINE void command_line::withdraw(std::string_view name, const void* target,
                                         std::string_view refusal) {
  if (option* const o = find(name); o != nullptr && o->target == target) o->refusal = refusal;
}

TALUS_INLINE void command_line::withdraw_soft(std::string_view refusal) {
  for (option& o : options_)
    if (o.soft) o.refusal = refusal;
}

TALUS_INLINE void command_line::add_settings(settings_reader* read) {
  add_option("--config", "read options from this file, as in steps = 200 (TOML); may be repeated",
             kind::file, nullptr);
  add_option("--set", "set one option, as in --set steps=200; may be repeated", kind::pair,
             nullptr);
  reader_ = read;
}

TALUS_INLINE command_line::option* command_line::find(std::string_view name) {
  for (option& o : options_)
    if (o.name == name) return &o;
  return nullptr;
}

/// In files and in --set a name has no dashes before it, and underscores are as good as dashes.
TALUS_INLINE command_line::option* command_line::find_key(std::string_view key) {
  const auto same = [](char a, char b) { return (a == '_' ? '-' : a) == (b == '_' ? '-' : b); };
  for (option& o : options_)
    if (std::equal(o.name.begin() + 2, o.name.end(), key.begin(), key.end(), same)) return &o;
  return nullptr;
}

TALUS_INLINE void command_line::parse(int argc, const char* const* argv) {
  const auto is_help = [](std::string_view word) {
    return word.substr(0, word.find('=')) == "--help";
  };
  // --help takes precedence over errors.
  for (int i = 1; i < argc; ++i)
    if (is_help(argv[i])) throw help_requested(help(argv[0]));
  std::string mistake = walk(argc, argv, true);
  if (mistake.empty()) mistake = walk(argc, argv, false);
  if (!mistake.empty()) throw usage_error(mistake);
  for (const auto& condition : conditions_) condition();
}

/// One walk along the command line, for its files or for all but these.
TALUS_INLINE std::string command_line::walk(int argc, const char* const* argv, bool files) {
  const auto name_in = [](std::string_view word) { return word.substr(0, word.find('=')); };
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i], name = name_in(word);
    option* const o = find(name);
    std::string wrong;
    std::string_view value = "true";
    bool has_value = true;
    if (o == nullptr) {
      if (files) continue;
      if (rest_ != nullptr && !word.starts_with('-'))
        rest_->emplace_back(word);
      else
        return unknown(word, false);
      continue;
    }
    if (name.size() < word.size())
      value = word.substr(name.size() + 1);
    else if (o->holds != kind::flag) {
      has_value = i + 1 < argc && find(name_in(argv[i + 1])) == nullptr;
      if (has_value) value = argv[++i];
    }
    if (!has_value) {
      if (files) continue;
      return i + 1 < argc ? detail::compose("{} needs a value, but {} follows; see --help", o->name,
                                            argv[i + 1])
                          : detail::compose("{} needs a value; see --help", o->name);
    }
    if (files != (o->holds == kind::file)) continue;
    if (o->holds == kind::file)
      wrong = value.empty() ? without_value(o->name) : read_file(std::string(value));
    else if (o->holds == kind::pair)
      wrong = read_pair(value);
    else
      wrong = read_value(*o, origin::word, value);
    if (!wrong.empty()) return wrong;
  }
  return {};
}

/// An empty text is a variable of the shell without a value.
TALUS_INLINE std::string command_line::without_value(const std::string& name) {
  return detail::compose("{} needs a value, but is empty: give it one, or leave it out", name);
}

/// A value from the command line.
TALUS_INLINE std::string command_line::read_value(option& o, origin from, std::string_view value) {
  if (!o.refusal.empty()) return o.refusal;
  if (o.from == from)
    return detail::compose("{} is given twice{}; see --help", o.name,
                           from == origin::set ? " by --set" : "");
  o.from = from;
  return read(o, value, o.name);
}

TALUS_INLINE std::string command_line::read(option& o, std::string_view value,
                                            const std::string& name) {
  if (o.holds == kind::text) {
    // Nothing stands for "not given".
    if (value.empty() && o.initial.empty()) return without_value(name);
    if (!detail::is_utf8(value))
      return detail::compose("{} needs a text in UTF-8, but is '{}'", name, std::string(value));
    // A line break in a name would make lines of its own in what the program prints.
    if (value.find('\n') != std::string_view::npos)
      return detail::compose("{} needs a text of one line, but is {}", name,
                             detail::quoted_text(value));
    // The system would end a name there.
    if (value.find('\0') != std::string_view::npos)
      return detail::compose("{} needs a text without zero bytes, but is {}", name,
                             detail::quoted_text(value));
    *static_cast<std::string*>(o.target) = value;
    return {};
  }
  if (o.holds != kind::flag) return read_number(o, value, name);
  const bool yes = value == "true" || value == "yes" || value == "on" || value == "1";
  if (!yes && value != "false" && value != "no" && value != "off" && value != "0")
    return detail::compose("{} is true or false, but is '{}'; see --help", name,
                           std::string(value));
  *static_cast<bool*>(o.target) = yes;
  return {};
}

TALUS_INLINE std::string command_line::read_number(option& o, std::string_view value,
                                                   const std::string& shown) {
  const char *at = value.data(), *const end = at + value.size();
  const bool minus = value.starts_with('-');
  if (minus || value.starts_with('+')) ++at;
  number v = 0;
  bool good = at != end && *at != '-';
  if (o.holds == kind::real) {
    double magnitude = 0;
    const auto read = std::from_chars(at, end, magnitude);
    good = good && read.ec == std::errc{} && read.ptr == end && std::isfinite(magnitude);
    v = magnitude;
  } else {
    // (std::from_chars for integers is a template, which costs every program a third of a second.)
    const bool hexadecimal = end - at > 2 && *at == '0' && (at[1] | 0x20) == 'x';
    if (hexadecimal) at += 2;
    const std::uint64_t base = hexadecimal ? 16 : 10;
    std::uint64_t magnitude = 0;
    for (; good && at != end; ++at) {
      const int c = *at, letter = (c | 0x20) - 'a';
      const bool decimal = c >= '0' && c <= '9';
      const auto digit = static_cast<std::uint64_t>(decimal ? c - '0' : letter + 10);
      good = (decimal || (hexadecimal && letter >= 0 && letter < 6)) &&
             magnitude <= (std::numeric_limits<std::uint64_t>::max() - digit) / base;
      magnitude = magnitude * base + digit;
    }
    v = static_cast<number>(magnitude);
  }
  if (minus) v = -v;
  if (!good || v < o.least || v > o.most)
    return detail::compose("{}: needs a {}{}, but is '{}'; see --help", shown,
                           o.holds == kind::real    ? "finite number"
                           : o.holds == kind::whole ? "whole number"
                                                    : "whole number of at least 0",
                           o.limits.empty() || shown == o.name ? "" : ", " + o.limits,
                           std::string(value));
  if (v < o.lower || v > o.upper)
    return detail::compose("{} must be {}, but is {}; see --help", shown, o.limits,
                           std::string(value));
  o.store(o.target, v);
  return {};
}

TALUS_INLINE std::string command_line::unknown(std::string_view word, bool key) const {
  const std::string name = (key ? "--" : "") + std::string(word.substr(0, word.find('=')));
  std::string_view closest = "--help";
  for (const option& o : options_)
    if (o.refusal.empty() && !(key && o.target == nullptr) &&
        edits(name, o.name) < edits(name, closest))
      closest = o.name;
  const std::size_t distance = edits(name, closest);
  if (key) closest.remove_prefix(2);
  if (distance > std::max<std::size_t>(2, closest.size() / 3) || closest == "help")
    return detail::compose("'{}' is not an option of this program; see --help", std::string(word));
  return detail::compose("'{}' is not an option of this program; did you mean {}? see --help",
                         std::string(word), std::string(closest));
}

TALUS_INLINE std::string command_line::help(std::string_view program) const {
  constexpr std::size_t column = 28;
  std::string text = description_;
  if (!text.empty()) text += '\n';
  text += "Usage: " + std::string(program) + " [OPTIONS]";
  if (rest_ != nullptr) text += " " + rest_name_;
  text += "\n\n";
  const auto line = [&](std::string name, std::string_view meaning) {
    name.insert(0, "  ");
    if (name.size() < column)
      name.append(column - name.size(), ' ');
    else
      name.append(1, '\n').append(column, ' ');
    text.append(name).append(meaning).append(1, '\n');
  };
  if (rest_ != nullptr) line(rest_name_, rest_meaning_);
  line("--help", "show this help and stop");
  for (const option& o : options_) {
    if (!o.refusal.empty()) continue;
    constexpr const char* types[] = {"",       " TEXT", " UINT",      " INT",
                                     " FLOAT", " FILE", " NAME=VALUE"};
    std::string name = o.name + types[static_cast<int>(o.holds)];
    if (!o.initial.empty()) name += "=" + o.initial;
    line(std::move(name), o.meaning);
  }
  return text;
}

/// With the fewest digits that identify it; numbers from a `float` with those of a float.
TALUS_INLINE std::string command_line::print(number value, kind holds) {
  if (holds == kind::real) {
    const auto single = static_cast<float>(value);
    if (value == single) return fmt::vformat("{}", fmt::make_format_args(single));
    return detail::text(static_cast<double>(value));
  }
  return value < 0 ? std::to_string(static_cast<std::int64_t>(value))
                   : std::to_string(static_cast<std::uint64_t>(value));
}

/// Insertions, deletions and changes of letters between two words (Levenshtein).
TALUS_INLINE std::size_t command_line::edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j)
      diagonal = std::exchange(
          row[j], std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])}));
  }
  return row.back();
}

}  // namespace talus
