#pragma once
// Errors are part of the interface: each message says what happened, where, and what to do.
#include <fmt/core.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "talus/core/math.hpp"

namespace talus {

/// Thrown on every other rank when one rank has failed, so that the whole job ends. The rank that
/// failed first carries the message; this one is never shown.
struct aborted : std::runtime_error {
  aborted() : std::runtime_error("another rank ended the run") {}
};

namespace detail {

template <class Error, class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> text, Args&&... args) {
  throw Error(fmt::format(text, std::forward<Args>(args)...));
}

/// A vector as the messages print it.
[[nodiscard]] inline std::string text(const vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v[0], v[1], v[2]);
}

[[nodiscard]] inline bool finite(const vec3& v) { return v.allFinite(); }

/// Throws invalid_argument unless `value` is finite and above zero.
inline void require_positive(real value, const char* what) {
  if (!(value > 0) || !std::isfinite(value))
    fail<std::invalid_argument>("{} must be positive and finite, but is {}; give a positive value",
                                what, value);
}

}  // namespace detail
}  // namespace talus
