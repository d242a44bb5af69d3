#pragma once
// Which manifolds are solved at once: blocks that keep the order of those that share a body.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Puts each element into the first block with room after all blocks that hold one of its bodies,
/// so that elements that share a body are solved in the order of the list (list scheduling). It
/// goes back by a limited number of blocks, so that the elements of a block are near in the list,
/// and in memory.
class ordered_planner {
 public:
  static constexpr std::size_t lanes = 8;

  void clear() {
    after_.assign(after_.size(), 0);
    filled_.clear(), open_.clear();
    begin_ = 0;
  }
  /// The elements that follow begin a new block.
  void begin_group() { begin_ = static_cast<std::uint32_t>(filled_.size()); }
  /// Slot (block * lanes + lane) for an element on the bodies a and b, -1 if b cannot move.
  [[nodiscard]] std::size_t place(std::int32_t a, std::int32_t b) {
    const auto highest = static_cast<std::size_t>(std::max(a, b));
    if (highest >= after_.size()) after_.resize(highest + highest / 2 + 1, 0);
    std::uint32_t first = std::max(begin_, after_[static_cast<std::size_t>(a)]);
    if (b >= 0) first = std::max(first, after_[static_cast<std::size_t>(b)]);
    const auto count = static_cast<std::uint32_t>(filled_.size());
    const std::uint32_t block = with_room(std::max(first, count > back ? count - back : 0));
    if (block == filled_.size()) filled_.push_back(0), open_.push_back(block);
    const std::size_t lane = filled_[block]++;
    if (filled_[block] == lanes) open_[block] = block + 1;
    after_[static_cast<std::size_t>(a)] = block + 1;
    if (b >= 0) after_[static_cast<std::size_t>(b)] = block + 1;
    return block * lanes + lane;
  }
  [[nodiscard]] std::size_t bytes() const {
    return (after_.capacity() + open_.capacity()) * sizeof(std::uint32_t) + filled_.capacity();
  }

 private:
  static constexpr std::uint32_t back = 256;

  /// The first block from `at` on that is not full; a new one may come after the last.
  std::uint32_t with_room(std::uint32_t at) {
    std::uint32_t found = at;
    while (found < open_.size() && open_[found] != found) found = open_[found];
    for (; at < found;) {  // blocks in between stay full
      const std::uint32_t next = open_[at];
      open_[at] = found;
      at = next;
    }
    return found;
  }

  plain_vector<std::uint32_t> after_;  ///< the first block after all that hold a body
  plain_vector<std::uint32_t> open_;   ///< a block itself while it has room, else a later one
  plain_vector<std::uint8_t> filled_;
  std::uint32_t begin_ = 0;  ///< the first block of the group
};

}  // namespace talus::detail
