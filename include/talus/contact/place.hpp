#pragma once
// Where the history keeps the contacts of a pair of bodies, noted where the pair is kept.
#include <cstdint>

namespace talus::detail {

/// Number of the first entry; or that the pair had no contact; or that it has to be looked up,
/// among all or among those that came from another rank since the last step.
enum class history_place : std::uint32_t {
  none = 0xffffffffu,
  unknown = 0xfffffffeu,
  arrived = 0xfffffffdu
};

}  // namespace talus::detail
