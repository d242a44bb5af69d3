#pragma once
// The number of contacts in the last step.
#include <cstdint>

#include "talus/state/state.hpp"

namespace talus::detail {

/// The contacts that count on this rank: each counts on exactly one rank.
template <class Scenario>
[[nodiscard]] std::uint64_t count_contacts(const world_state<Scenario>& s) {
  std::uint64_t contacts = 0;
  s.each_contact_list([&](const auto& list) { contacts += list.counted(); });
  return contacts;
}

}  // namespace talus::detail
