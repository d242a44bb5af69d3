#pragma once
// Blocks of contacts that share no body anyway, as those of one colour.
#include <cstddef>
#include <cstdint>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Fills one block after the other. A contact or manifold with the same bodies as the last one, as
/// further manifolds of a pair, begins a new block.
template <int Lanes>
class in_sequence {
 public:
  static constexpr std::size_t lanes = Lanes;

  void clear() { next_ = 0, a_ = b_ = -1, filled_.clear(); }
  /// Slot (block * Lanes + lane) for the bodies a and b, -1 if b cannot move.
  [[nodiscard]] std::int64_t place(std::int32_t a, std::int32_t b) {
    if (a == a_ && b == b_) next_ = (next_ + Lanes - 1) / Lanes * Lanes;
    a_ = a, b_ = b;
    if (next_ % Lanes == 0) filled_.push_back(0);
    ++filled_.back();
    return next_++;
  }
  /// The number of lanes of a block that have contacts: its first ones.
  [[nodiscard]] std::size_t filled(std::size_t block) const { return filled_[block]; }
  [[nodiscard]] std::size_t bytes() const { return filled_.capacity(); }

 private:
  std::int64_t next_ = 0;
  std::int32_t a_ = -1, b_ = -1;
  plain_vector<std::uint8_t> filled_;
};

}  // namespace talus::detail
