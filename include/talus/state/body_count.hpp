#pragma once
// A number of bodies with the sum of their ids, modulo 2^64. Two such sums that differ by one body
// differ by its id, so the id of a missing or duplicate body is known, in any order of summation.
#include <cstdint>
#include <string>

#include "talus/core/error.hpp"
#include "talus/core/id.hpp"

namespace talus {

/// A number of bodies, and a check sum of their ids.
struct body_count {
  /// number of bodies
  std::uint64_t bodies = 0;
  std::uint64_t ids = 0;  ///< their sum, modulo 2^64

  void add(system_id id) { ++bodies, ids += value_of(id); }
  void remove(system_id id) { --bodies, ids -= value_of(id); }
  friend bool operator==(const body_count&, const body_count&) = default;
  /// Modulo 2^64, as all sums here.
  friend body_count operator-(const body_count& a, const body_count& b) {
    return {a.bodies - b.bodies, a.ids - b.ids};
  }
  friend body_count operator+(const body_count& a, const body_count& b) {
    return {a.bodies + b.bodies, a.ids + b.ids};
  }
};

namespace detail {

/// The excess (or deficit) of `count`, and the id of the body if it is a single one.
struct surplus {
  std::int64_t bodies;
  system_id id;  ///< of a single one

  surplus(const body_count& count, const body_count& expected)
      : bodies(static_cast<std::int64_t>((count - expected).bodies)),
        id(bodies == 1    ? system_id{(count - expected).ids}
           : bodies == -1 ? system_id{(expected - count).ids}
                          : no_id) {}
  [[nodiscard]] bool single() const { return bodies == 1 || bodies == -1; }
  /// "body 0x5", "3 bodies", or "a body that became another one".
  [[nodiscard, gnu::cold]] std::string text() const {
    if (single()) return "body " + detail::text(id);
    if (bodies == 0) return "a body that changed its id";
    return std::to_string(bodies < 0 ? -bodies : bodies) + " bodies";
  }
};

}  // namespace detail
}  // namespace talus
