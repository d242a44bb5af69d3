#pragma once
// The identity of a contact from step to step and from rank to rank.
#include <cstdint>

#include "talus/core/id.hpp"

namespace talus::detail {

/// (id, id, feature): body a, body b, and the point of their manifold. Both ranks of a contact
/// build the same key, because the order of the two bodies depends on their shapes and ids alone.
struct contact_key {
  system_id a = no_id;
  system_id b = no_id;
  std::uint64_t feature = 0;

  friend bool operator==(const contact_key&, const contact_key&) = default;

  [[nodiscard]] bool same_pair(const contact_key& other) const {
    return a == other.a && b == other.b;
  }
  /// A hash of the two ids without the feature, so that all contacts of a pair are found together.
  [[nodiscard]] std::uint64_t hash() const {
    return mix(value_of(a) ^ (value_of(b) * 0x9e3779b97f4a7c15ull));
  }
};

}  // namespace talus::detail
