#pragma once
// Data that ranks exchange about the bodies that they share.
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "talus/core/math.hpp"

namespace talus::detail {

/// The ranks that know a body, besides its owner: at most four, otherwise the list is unusable.
class body_holders {
 public:
  void add(int rank) {
    if (crowded() || rank >= 0xfffe) {
      bits_ = ~std::uint64_t{0};
      return;
    }
    int place = 0;
    while (place < 64 && (bits_ >> place & 0xffff) != 0) place += 16;
    bits_ = place == 64 ? ~std::uint64_t{0} : bits_ | static_cast<std::uint64_t>(rank + 1) << place;
  }
  void add(const body_holders& other) {
    if (other.crowded()) bits_ = other.bits_;
    for (int place = 0; place < 64 && !crowded(); place += 16)
      if (const auto rank = static_cast<int>(other.bits_ >> place & 0xffff) - 1; rank >= 0)
        add(rank);
  }
  [[nodiscard]] bool has(int rank) const {
    if (crowded()) return false;
    for (int place = 0; place < 64; place += 16)
      if ((bits_ >> place & 0xffff) == static_cast<std::uint64_t>(rank + 1)) return true;
    return false;
  }
  /// Removes the ranks that `other` does not contain, but for `owner`.
  void keep(const body_holders& other, int owner) {
    if (crowded()) return;
    const std::uint64_t all = std::exchange(bits_, 0);
    for (int place = 0; place < 64; place += 16)
      if (const auto rank = static_cast<int>(all >> place & 0xffff) - 1;
          rank >= 0 && (rank == owner || other.has(rank)))
        add(rank);
  }
  // Its encoding among numbers of a message: in two halves, because some bit patterns are not
  // numbers.
  [[nodiscard]] std::array<real, 2> packed() const {
    return {static_cast<real>(bits_ >> 32), static_cast<real>(bits_ & 0xffffffffu)};
  }
  void unpack(real high, real low) {
    bits_ = static_cast<std::uint64_t>(high) << 32 | static_cast<std::uint64_t>(low);
  }

 private:
  [[nodiscard]] bool crowded() const { return bits_ == ~std::uint64_t{0}; }
  std::uint64_t bits_ = 0;
};

/// The bodies whose copies are exchanged between this rank and another one, as indices into the
/// solver's arrays.
struct travelling_bodies {
  int rank = 0;
  std::span<const std::uint32_t> sent, received;
};

/// A fixed body that several ranks know.
struct fixed_body_ties {
  std::uint32_t body = 0;  ///< index into the solver's arrays
  std::int32_t owner = -1;
  body_holders holders;
};

/// The data that a rank sends of a body to the holders of its copies.
struct body_ties {
  std::uint32_t contacts = 0;  ///< known to this rank
  std::int32_t of_owner = -1;  ///< known to its owner; -1 if that takes no part
  std::int32_t owner = -1;
  body_holders holders;
};

}  // namespace talus::detail
