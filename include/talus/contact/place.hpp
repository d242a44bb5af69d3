#pragma once
// The place of the contacts of a pair of bodies in the history, stored with the candidate pair.
#include <cstdint>

namespace talus::detail {

/// Index of the first entry; or a mark that the pair had no contact; or that it must be looked up,
/// among all or among those that came from another rank since the last step.
enum class history_place : std::uint32_t {
  none = 0xffffffffu,
  unknown = 0xfffffffeu,
  arrived = 0xfffffffdu
};

}  // namespace talus::detail
