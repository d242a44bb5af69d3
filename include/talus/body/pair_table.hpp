#pragma once
// Values of pairs of materials: a hash table with an entry for each pair that has a value of its
// own, instead of all pairs.
#include <cstddef>
#include <cstdint>
#include <utility>

#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Maps unordered pairs of small numbers to values. Open addressing with linear probing, at most
/// half full.
template <class Value>
class pair_table {
 public:
  struct entry {
    std::uint32_t low = 0, high = 0;  ///< of the pair, low <= high
    Value value;
  };

  [[nodiscard]] const Value* find(std::uint32_t a, std::uint32_t b) const {
    if (places_.empty()) return nullptr;
    if (b < a) std::swap(a, b);
    for (std::size_t at = place_of(a, b);; at = (at + 1) & mask_) {
      const std::uint32_t n = places_[at];
      if (n == 0) return nullptr;
      const entry& e = entries_[n - 1];
      if (e.low == a && e.high == b) return &e.value;
    }
  }
  /// Sets the value of a pair. Returns whether the pair is new.
  bool set(std::uint32_t a, std::uint32_t b, const Value& value) {
    if (b < a) std::swap(a, b);
    if (const Value* known = find(a, b)) {
      *const_cast<Value*>(known) = value;
      return false;
    }
    entries_.push_back({a, b, value});
    if (2 * entries_.size() > places_.size())
      grow();
    else
      insert(static_cast<std::uint32_t>(entries_.size()));
    return true;
  }
  /// In the order in which the pairs were set.
  [[nodiscard]] const plain_vector<entry>& entries() const { return entries_; }
  [[nodiscard]] std::size_t bytes() const {
    return entries_.capacity() * sizeof(entry) + places_.capacity() * sizeof(std::uint32_t);
  }
  void clear() {
    entries_.clear();
    places_.clear();
  }

 private:
  [[nodiscard]] std::size_t place_of(std::uint32_t a, std::uint32_t b) const {
    const std::uint64_t key = std::uint64_t{a} << 32 | b;
    return static_cast<std::size_t>(key * 0x9e3779b97f4a7c15u >> 32) & mask_;
  }
  void insert(std::uint32_t n) {
    std::size_t at = place_of(entries_[n - 1].low, entries_[n - 1].high);
    while (places_[at] != 0) at = (at + 1) & mask_;
    places_[at] = n;
  }
  [[gnu::cold]] void grow() {
    const std::size_t size = places_.empty() ? 16 : 2 * places_.size();
    places_.clear();
    places_.resize(size);
    for (std::size_t k = 0; k < size; ++k) places_[k] = 0;
    mask_ = size - 1;
    for (std::uint32_t n = 1; n <= entries_.size(); ++n) insert(n);
  }

  plain_vector<entry> entries_;
  plain_vector<std::uint32_t> places_;  ///< index of an entry from 1, or 0 if empty
  std::size_t mask_ = 0;
};

}  // namespace talus::detail
