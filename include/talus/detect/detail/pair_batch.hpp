#pragma once
// Batches of pairs from the broad phase.
#include <cstdint>

namespace talus::detail {

/// Passes pairs (i, j) to a callable in batches, so that the searches are compiled once for all
/// uses of the pairs.
class pair_batch {
 public:
  /// `f` outlives the batch.
  template <class F>
  explicit pair_batch(F& f)
      : to_(&f), hand_over_([](void* to, const pair* pairs, std::uint32_t count) {
          auto& take = *static_cast<F*>(to);
          for (std::uint32_t k = 0; k < count; ++k) take(pairs[k].i, pairs[k].j);
        }) {}
  pair_batch(const pair_batch&) = delete;
  pair_batch& operator=(const pair_batch&) = delete;

  void add(std::uint32_t i, std::uint32_t j) {
    pairs_[count_++] = {i, j};
    if (count_ == capacity) flush();
  }
  /// Call it after the last pair.
  void flush() {
    const std::uint32_t count = count_;
    count_ = 0;
    hand_over_(to_, pairs_, count);
  }

 private:
  struct pair {
    std::uint32_t i, j;
  };

  static constexpr std::uint32_t capacity = 256;
  pair pairs_[capacity];
  std::uint32_t count_ = 0;
  void* to_;
  void (*hand_over_)(void*, const pair*, std::uint32_t);
};

}  // namespace talus::detail
