#pragma once
// Definitions of scene/command_line.hpp.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "talus/scene/command_line.hpp"

namespace talus {

[[gnu::cold]] inline void command_line::add_option(std::string_view name, std::string_view meaning,
                                                   kind holds, void* target) {
  if (!name.starts_with("--") || name.size() < 3 || name.find_first_of("= ") != name.npos)
    throw std::invalid_argument("the option '" + std::string(name) +
                                "' needs a name like --spheres");
  if (name == "--help" || find(name) != nullptr)
    throw std::invalid_argument("the option " + std::string(name) + " is described twice");
  option& o = options_.emplace_back();
  o.name = name;
  o.meaning = meaning;
  o.holds = holds;
  o.target = target;
  if (holds == kind::text) o.initial = *static_cast<std::string*>(target);
}

[[gnu::cold]] inline void command_line::add_number(std::string_view name, std::string_view meaning,
                                                   kind holds, void* target, number initial,
                                                   void (*store)(void*, number), number least,
                                                   number most) {
  add_option(name, meaning, holds, target);
  option& o = options_.back();
  o.initial = print(initial, holds);
  o.store = store;
  o.lower = o.least = least;
  o.upper = o.most = most;
}

[[gnu::cold]] inline void command_line::limit(number lower, number upper, number initial) {
  option& o = options_.back();
  o.limits = upper == o.most ? "at least " + print(lower, o.holds)
                             : "between " + print(lower, o.holds) + " and " + print(upper, o.holds);
  o.lower = lower;
  o.upper = upper;
  if (initial < lower || initial > upper) o.initial.clear();
}

[[gnu::cold]] inline void command_line::limit_to_positive() {
  options_.back().limits = "positive";
  options_.back().lower = std::numeric_limits<double>::denorm_min();
}

[[gnu::cold]] inline void command_line::add_rest(std::string_view name,
                                                 std::vector<std::string>& values,
                                                 std::string_view meaning) {
  rest_ = &values;
  rest_name_ = name;
  rest_meaning_ = meaning;
}

[[gnu::cold]] inline command_line::option* command_line::find(std::string_view name) {
  for (option& o : options_)
    if (o.name == name) return &o;
  return nullptr;
}

[[gnu::cold]] inline void command_line::parse(int argc, const char* const* argv) {
  const auto name_in = [](std::string_view word) { return word.substr(0, word.find('=')); };
  // Help is given whatever else is wrong, so the first mistake waits for the last word.
  std::string mistake;
  for (int i = 1; i < argc; ++i) {
    const std::string_view word = argv[i], name = name_in(word);
    if (name == "--help") throw help_requested(help(argv[0]));
    option* const o = find(name);
    std::string wrong;
    if (o == nullptr) {
      if (rest_ != nullptr && !word.starts_with('-'))
        rest_->emplace_back(word);
      else
        wrong = unknown(word);
    } else if (name.size() < word.size()) {
      wrong = read(*o, word.substr(name.size() + 1));
    } else if (o->holds == kind::flag) {
      wrong = read(*o, "true");
    } else if (i + 1 < argc && name_in(argv[i + 1]) != "--help" &&
               find(name_in(argv[i + 1])) == nullptr) {
      wrong = read(*o, argv[++i]);
    } else {
      wrong = o->name + " needs a value" +
              (i + 1 < argc ? ", but " + std::string(argv[i + 1]) + " follows" : "") +
              "; see --help";
    }
    if (mistake.empty()) mistake = std::move(wrong);
  }
  if (!mistake.empty()) throw usage_error(mistake);
  for (const auto& condition : conditions_) condition();
}

[[gnu::cold]] inline std::string command_line::read(option& o, std::string_view value) {
  if (std::exchange(o.given, true)) return o.name + " is given twice; see --help";
  if (o.holds == kind::text) {
    *static_cast<std::string*>(o.target) = value;
    return {};
  }
  if (o.holds != kind::flag) return read_number(o, value);
  const bool yes = value == "true" || value == "yes" || value == "on" || value == "1";
  if (!yes && value != "false" && value != "no" && value != "off" && value != "0")
    return o.name + " is true or false, but is '" + std::string(value) + "'; see --help";
  *static_cast<bool*>(o.target) = yes;
  return {};
}

[[gnu::cold]] inline std::string command_line::read_number(option& o, std::string_view value) {
  const char *begin = value.data(), *end = begin + value.size();
  const bool minus = value.starts_with('-');
  if (minus || value.starts_with('+')) ++begin;
  number v = 0;
  std::from_chars_result read{};
  if (begin == end || *begin == '-') {
    read.ec = std::errc::invalid_argument;
  } else if (o.holds == kind::real) {
    double magnitude = 0;
    read = std::from_chars(begin, end, magnitude);
    v = magnitude;
  } else {
    const bool hexadecimal = end - begin > 2 && *begin == '0' && (begin[1] | 0x20) == 'x';
    unsigned long long magnitude = 0;
    read = std::from_chars(begin + 2 * hexadecimal, end, magnitude, hexadecimal ? 16 : 10);
    v = magnitude;
  }
  if (minus) v = -v;
  // What neither is read to its end nor fits; not finite; a minus before something without a sign.
  if (read.ec != std::errc{} || read.ptr != end || !std::isfinite(v) || v < o.least || v > o.most)
    return o.name + ": needs a " +
           (o.holds == kind::real    ? "finite number"
            : o.holds == kind::whole ? "whole number"
                                     : "whole number of at least 0") +
           ", but is '" + std::string(value) + "'; see --help";
  if (v < o.lower || v > o.upper)
    return o.name + " must be " + o.limits + ", but is " + std::string(value) + "; see --help";
  o.store(o.target, v);
  return {};
}

[[gnu::cold]] inline std::string command_line::unknown(std::string_view word) const {
  const std::string_view name = word.substr(0, word.find('='));
  std::string_view closest = "--help";
  for (const option& o : options_)
    if (edits(name, o.name) < edits(name, closest)) closest = o.name;
  std::string message = "'" + std::string(word) + "' is not an option of this program; ";
  if (edits(name, closest) <= std::max<std::size_t>(2, closest.size() / 3))
    message += "did you mean " + std::string(closest) + "? ";
  return message + "see --help";
}

[[gnu::cold]] inline std::string command_line::help(std::string_view program) const {
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
    constexpr const char* types[] = {"", " TEXT", " UINT", " INT", " FLOAT"};
    std::string name = o.name + types[static_cast<int>(o.holds)];
    if (!o.initial.empty()) name += "=" + o.initial;
    line(std::move(name), o.meaning);
  }
  return text;
}

/// In as few digits as tell it apart; numbers from a `float` by those of a float.
[[gnu::cold]] inline std::string command_line::print(number value, kind holds) {
  char digits[40];
  char* end = digits + sizeof digits;
  if (holds == kind::real && value == static_cast<float>(value))
    end = std::to_chars(digits, end, static_cast<float>(value)).ptr;
  else if (holds == kind::real)
    end = std::to_chars(digits, end, static_cast<double>(value)).ptr;
  else if (value < 0)
    end = std::to_chars(digits, end, static_cast<long long>(value)).ptr;
  else
    end = std::to_chars(digits, end, static_cast<unsigned long long>(value)).ptr;
  return {digits, end};
}

/// Insertions, deletions and changes of letters between two words (Levenshtein).
[[gnu::cold]] inline std::size_t command_line::edits(std::string_view a, std::string_view b) {
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
