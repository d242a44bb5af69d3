#pragma once
// Counts of sent messages and bytes, which show that a step communicates with neighbours only.
#include <cstdint>

namespace talus {

/// Sent by one rank since its link was made. Collectives are counted as calls, not by their bytes.
struct traffic {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  std::uint64_t collectives = 0;

  friend bool operator==(const traffic&, const traffic&) = default;
  /// The traffic between two readings.
  friend traffic operator-(const traffic& now, const traffic& before) {
    return {now.messages - before.messages, now.bytes - before.bytes,
            now.collectives - before.collectives};
  }
};

}  // namespace talus
