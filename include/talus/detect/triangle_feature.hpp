#pragma once
// Numbers of the triangles of a surface in the features of contacts.
#include <cstdint>

namespace talus::detail {

/// The number of a triangle beside the parts that meet: 12 bits of it above the four that its own
/// corners, edges and sides need, the rest in bits 48 to 63.
[[nodiscard]] inline std::uint64_t feature_of(std::uint32_t triangle, std::uint64_t parts) {
  return parts | (std::uint64_t{triangle} & 0xfff) << 4 | std::uint64_t{triangle >> 12} << 48;
}

[[nodiscard]] inline std::uint32_t triangle_of(std::uint64_t feature) {
  return static_cast<std::uint32_t>((feature >> 4 & 0xfff) | feature >> 48 << 12);
}
inline constexpr std::uint64_t other_parts = 0x0000ffffffff0000;  ///< of the other body

}  // namespace talus::detail
