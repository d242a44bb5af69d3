#pragma once
// Which contacts are solved at once: greedy colouring in blocks.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Finds for each contact the first block of `Lanes` that has room and contains none of its bodies.
/// Blocks are open for a limited time only, so that they hold neighbours in the list, which are
/// neighbours in space.
template <int Lanes>
class block_planner {
 public:
  void clear() {
    std::fill(used_.begin(), used_.end(), use{});
    filled_.clear();
    first_ = 0;
    full_ = 0;
  }
  /// Slot (block * Lanes + lane) for a contact of a and b, -1 if b cannot move; or -1 if all open
  /// blocks contain one of its bodies.
  [[nodiscard]] std::int64_t place(std::int32_t a, std::int32_t b) {
    const auto highest = static_cast<std::size_t>(std::max(a, b));
    if (highest >= used_.size()) used_.resize(highest + highest / 2 + 1);
    std::uint64_t taken = full_ | near(a);
    if (b >= 0) taken |= near(b);
    const int at = std::countr_one(taken);
    if (at == open) return -1;
    const std::size_t block = first_ + static_cast<std::size_t>(at);
    if (block >= filled_.size()) filled_.resize(block + 1, 0);
    const int lane = filled_[block]++;
    mark(a, at);
    if (b >= 0) mark(b, at);
    if (lane + 1 == Lanes) {
      full_ |= std::uint64_t{1} << at;
      const int done = std::countr_one(full_);
      first_ += static_cast<std::size_t>(done);
      full_ = done == open ? 0 : full_ >> done;
    }
    return static_cast<std::int64_t>(block) * Lanes + lane;
  }
  /// How many lanes of a block are in use: the first.
  [[nodiscard]] unsigned filled(std::size_t block) const { return filled_[block]; }
  [[nodiscard]] std::size_t bytes() const {
    return used_.capacity() * sizeof(use) + filled_.capacity();
  }

 private:
  static constexpr int open = 64;
  /// The set of open blocks that contain a body, when block `first` was the first of these.
  struct use {
    std::size_t first = 0;
    std::uint64_t blocks = 0;
  };

  [[nodiscard]] std::uint64_t near(std::int32_t body) const {
    const use& u = used_[static_cast<std::size_t>(body)];
    const std::size_t passed = first_ - u.first;
    const std::uint64_t in = passed < open ? u.blocks >> passed : 0;
    return in | in << 1;  // consecutive blocks share no body, or one would wait
  }
  void mark(std::int32_t body, int at) {
    use& u = used_[static_cast<std::size_t>(body)];
    const std::size_t passed = first_ - u.first;
    u.blocks = (passed < open ? u.blocks >> passed : 0) | std::uint64_t{1} << at;
    u.first = first_;
  }

  plain_vector<use> used_;
  plain_vector<std::uint8_t> filled_;
  std::size_t first_ = 0;
  std::uint64_t full_ = 0;
};

}  // namespace talus::detail
