#pragma once
// System ids: unique over all ranks, made without communication.
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace talus {

/// Identity of a body, the same on every rank. The two highest bits encode the source of the
/// number, so that ids from the three sources never collide.
enum class system_id : std::uint64_t {};

inline constexpr system_id no_id{~std::uint64_t{0}};

namespace detail {

/// The largest number of calls of fill.
inline constexpr std::uint64_t most_fills = 1 << 14;

/// Id of the body at site `site` of the `fill`-th call of fill: the same for every rank count.
constexpr system_id id_of_site(std::uint64_t fill, std::uint64_t site) {
  return system_id{(fill & (most_fills - 1)) << 48 | (site & 0xffff'ffff'ffffull)};
}
/// Id of the `attempt`-th creation that all ranks of an SPMD program attempt together.
constexpr system_id id_of_attempt(std::uint64_t attempt) {
  return system_id{std::uint64_t{1} << 62 | attempt};
}
/// Id of the `count`-th body that `rank` creates on its own.
constexpr system_id id_of_rank(std::uint64_t rank, std::uint64_t count) {
  return system_id{std::uint64_t{2} << 62 | (rank & 0xff'ffff) << 38 | count};
}
/// Finaliser of splitmix64: a bijection that spreads every bit (Steele, Lea, Flood 2014).
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

}  // namespace detail

constexpr std::uint64_t value_of(system_id id) { return static_cast<std::uint64_t>(id); }

}  // namespace talus

template <>
struct std::hash<talus::system_id> {
  std::size_t operator()(talus::system_id id) const noexcept {
    return static_cast<std::size_t>(talus::detail::mix(talus::value_of(id)));
  }
};
