#pragma once
// Errors are part of the interface: each message says what happened, where, and what to do.
#include <fmt/core.h>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "talus/core/id.hpp"
#include "talus/core/math.hpp"

namespace talus {

/// Thrown on all other ranks when one rank has failed, so that the whole job ends. The rank that
/// failed first reports the message; this one is never shown.
struct aborted : std::runtime_error {
  aborted() : std::runtime_error("another rank ended the run") {}
};

namespace detail {

// How values appear in messages and tables.
// (vformat parses the text at run time; parsing at compile time costs every program.)
[[nodiscard, gnu::cold]] inline std::string text(real x) {
  x += 0.0;  // zero has no sign
  return fmt::vformat("{}", fmt::make_format_args(x));
}
[[nodiscard, gnu::cold]] inline std::string text(real x, int digits) {
  return fmt::vformat("{:.{}g}", fmt::make_format_args(x, digits));
}
/// A vector to six digits.
[[nodiscard, gnu::cold]] inline std::string text(const vec3& v) {
  return fmt::vformat("({:.6g}, {:.6g}, {:.6g})", fmt::make_format_args(v[0], v[1], v[2]));
}
[[nodiscard, gnu::cold]] inline std::string text(system_id id) {
  const std::uint64_t number = value_of(id);
  return fmt::vformat("{:#x}", fmt::make_format_args(number));
}
/// The text of a message, with a {} for each value, or {0}, {1}, ... for repeated or reordered
/// values. A text that does not match its values does not compile. (fmt would check this too, at
/// ten times the cost: every program compiles a hundred messages.) The article "a" before a word
/// that begins with a vowel becomes "an".
template <class... Values>
struct message_words {
  consteval message_words(const char* words) : words(words) {
    std::size_t gaps = 0;
    for (const char* c = words; *c != 0; ++c) {
      if (*c == '}') throw "a } in a message without its {";
      if (*c != '{') continue;
      std::size_t number = gaps;
      if (*++c >= '0' && *c <= '9') number = static_cast<std::size_t>(*c++ - '0');
      if (*c != '}') throw "a { in a message is followed by } or a digit and }";
      if (number >= sizeof...(Values)) throw "a message has more {} than values";
      ++gaps;
    }
    if (gaps < sizeof...(Values)) throw "a message has more values than {}";
  }
  const char* words;
};

/// A value for a placeholder, by reference: it is valid during the call.
class message_value {
 public:
  message_value(const real& x) : kind_(kind::real), at_(&x) {}
  message_value(const vec3& v) : kind_(kind::vector), at_(&v) {}
  message_value(const system_id& id) : kind_(kind::id), at_(&id) {}
  message_value(const std::string& s) : kind_(kind::string), at_(&s) {}
  message_value(const char* s) : kind_(kind::words), at_(s) {}
  message_value(const char& c) : kind_(kind::letter), at_(&c) {}
  template <std::integral Integer>
  message_value(Integer i)
      : kind_(kind::integer),
        minus_(i < 0),
        magnitude_(minus_ ? 0 - static_cast<std::uint64_t>(i) : static_cast<std::uint64_t>(i)) {}

  /// Whether it is a word of talus, such as the name of a shape, that takes the article "an".
  [[nodiscard]] bool takes_an() const {
    if (kind_ != kind::words) return false;
    const char c = *static_cast<const char*>(at_);
    return c == 'a' || c == 'e' || c == 'i' || c == 'o';
  }
  [[nodiscard]] std::string text() const {
    switch (kind_) {
      case kind::real:
        return detail::text(*static_cast<const talus::real*>(at_));
      case kind::vector:
        return detail::text(*static_cast<const vec3*>(at_));
      case kind::id:
        return detail::text(*static_cast<const system_id*>(at_));
      case kind::string:
        return *static_cast<const std::string*>(at_);
      case kind::words:
        return static_cast<const char*>(at_);
      case kind::letter:
        return std::string(1, *static_cast<const char*>(at_));
      case kind::integer:
        break;
    }
    std::string digits = minus_ ? "-" : "";
    digits += std::to_string(magnitude_);
    return digits;
  }

 private:
  enum class kind : char { real, vector, id, string, words, letter, integer };
  kind kind_;
  bool minus_ = false;
  std::uint64_t magnitude_ = 0;
  const void* at_ = nullptr;
};

[[nodiscard, gnu::cold, gnu::noinline]] inline std::string fill_gaps(const char* words,
                                                                     const message_value* values) {
  std::string filled;
  const auto insert = [&](const message_value& value) {
    const std::size_t n = filled.size();
    const bool article =
        n >= 2 && filled[n - 1] == ' ' && filled[n - 2] == 'a' && (n == 2 || filled[n - 3] == ' ');
    if (article && value.takes_an()) filled.insert(n - 1, 1, 'n');
    filled += value.text();
  };
  for (std::size_t gap = 0; *words != 0; ++words) {
    if (*words != '{') {
      filled += *words;
    } else if (*++words == '}') {
      insert(values[gap++]);
    } else {
      insert(values[*words++ - '0']);
    }
  }
  return filled;
}
template <class Error>
[[noreturn, gnu::cold, gnu::noinline]] void throw_filled(const char* words,
                                                         const message_value* values) {
  throw Error(fill_gaps(words, values));
}

/// The text with the values inserted.
template <class... Values>
[[nodiscard]] std::string compose(message_words<std::type_identity_t<Values>...> message,
                                  const Values&... values) {
  const message_value all[] = {values..., ""};
  return fill_gaps(message.words, all);
}

/// Throws an Error with such a message.
template <class Error, class... Values>
[[noreturn]] void fail(message_words<std::type_identity_t<Values>...> message,
                       const Values&... values) {
  const message_value all[] = {values..., ""};
  throw_filled<Error>(message.words, all);
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

/// Sizes of shapes lie between these, so that volumes, squares of lengths and moments of inertia
/// are normal numbers.
inline constexpr real smallest_size = 1e-120, largest_size = 1e120;

/// Throws invalid_argument unless `value`, a size of a shape, is positive and of such a magnitude.
inline void require_size(real value, const char* what) {
  require_positive(value, what);
  if (value < smallest_size || value > largest_size)
    fail<std::invalid_argument>(
        "{} is {}, beyond what numbers can hold: sizes lie between {} and {}; choose units in "
        "which "
        "it is nearer to 1",
        what, value, smallest_size, largest_size);
}

}  // namespace detail
}  // namespace talus
