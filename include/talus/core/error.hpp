#pragma once
// Errors are part of the interface: each message says what happened, where, and what to do.
#include <fmt/core.h>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// Thrown on every other rank when one rank has failed, so that the whole job ends. The rank that
/// failed first carries the message; this one is never shown.
struct aborted : std::runtime_error {
  aborted() : std::runtime_error("another rank ended the run") {}
};

namespace detail {

// How values appear in messages.
[[nodiscard]] inline std::string text(real x) { return fmt::format("{}", x); }
/// A vector to six digits.
[[nodiscard]] inline std::string text(const vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]);
}
[[nodiscard]] inline std::string text(system_id id) { return fmt::format("{:#x}", value_of(id)); }
[[nodiscard]] inline std::string text(const std::string& s) { return s; }
[[nodiscard]] inline std::string text(const char* s) { return s; }
[[nodiscard]] inline std::string text(char c) { return std::string(1, c); }
template <std::integral Integer>
[[nodiscard]] std::string text(Integer i) {
  return std::to_string(i);
}

/// The words of a message, with a {} for each value. One that does not fit its values does not
/// compile. (fmt would check it too, at ten times the cost: there are a hundred messages, and
/// every program compiles them.)
template <class... Values>
struct message_words {
  consteval message_words(const char* words) : words(words) {
    std::size_t gaps = 0;
    for (const char* c = words; *c != 0; ++c)
      if (*c == '{' || *c == '}') {
        if (c[0] != '{' || c[1] != '}') throw "in a message, braces come in pairs: {}";
        ++gaps, ++c;
      }
    if (gaps != sizeof...(Values)) throw "a message has as many {} as values";
  }
  const char* words;
};

[[nodiscard]] inline std::string fill_gaps(const char* words, const std::string* values) {
  std::string filled;
  for (; *words != 0; ++words) {
    if (*words == '{') {
      filled += *values++;
      ++words;
    } else {
      filled += *words;
    }
  }
  return filled;
}

/// The words, with the values in their gaps.
template <class... Values>
[[nodiscard]] std::string compose(message_words<std::type_identity_t<Values>...> message,
                                  const Values&... values) {
  const std::string all[] = {text(values)..., {}};
  return fill_gaps(message.words, all);
}

template <class Error, class... Values>
[[noreturn]] void fail(message_words<std::type_identity_t<Values>...> message,
                       const Values&... values) {
  const std::string all[] = {text(values)..., {}};
  throw Error(fill_gaps(message.words, all));
}

[[nodiscard]] inline bool finite(const vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}
[[nodiscard]] inline bool has_nan(const vec3& v) {
  return std::isnan(v[0]) || std::isnan(v[1]) || std::isnan(v[2]);
}

/// Throws invalid_argument unless `value` is finite and above zero.
inline void require_positive(real value, const char* what) {
  if (!(value > 0) || !std::isfinite(value))
    fail<std::invalid_argument>("{} must be positive and finite, but is {}; give a positive value",
                                what, value);
}

}  // namespace detail
}  // namespace talus
