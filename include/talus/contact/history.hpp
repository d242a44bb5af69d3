#pragma once
// What contacts remember from one step to the next: their impulse, for warm starting.
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "talus/contact/key.hpp"
#include "talus/core/math.hpp"

namespace talus::detail {

struct remembered_contact {
  contact_key key;
  vec3 impulse{0, 0, 0};  ///< on body a, world frame
};

/// Contacts of the last step, found by key: open addressing, rebuilt every step.
class contact_history {
 public:
  void clear() {
    entries_.clear();
    slots_.assign(slots_.size(), 0);
  }
  /// Makes room for `n` contacts; call before adding.
  void reset(std::size_t n) {
    entries_.clear();
    entries_.reserve(n);
    const auto wanted = std::bit_ceil(2 * n + 16);
    if (slots_.size() < wanted || slots_.size() > 8 * wanted)
      slots_.assign(wanted, 0);
    else
      std::fill(slots_.begin(), slots_.end(), 0);
  }
  void add(const contact_key& key, const vec3& impulse) {
    if (2 * (entries_.size() + 1) > slots_.size()) grow();
    entries_.push_back({key, impulse});
    insert(entries_.size());
  }
  /// The impulse of the contact in the last step, or null where it is new.
  [[nodiscard]] const vec3* find(const contact_key& key) const {
    if (slots_.empty()) return nullptr;
    const auto mask = slots_.size() - 1;
    for (auto s = key.hash() & mask; slots_[s] != 0; s = (s + 1) & mask)
      if (entries_[slots_[s] - 1].key == key) return &entries_[slots_[s] - 1].impulse;
    return nullptr;
  }
  /// Calls f(remembered_contact) for all contacts of a pair.
  template <class F>
  void each_of_pair(const contact_key& pair, F&& f) const {
    if (slots_.empty()) return;
    const auto mask = slots_.size() - 1;
    for (auto s = pair.hash() & mask; slots_[s] != 0; s = (s + 1) & mask)
      if (entries_[slots_[s] - 1].key.same_pair(pair)) f(entries_[slots_[s] - 1]);
  }
  [[nodiscard]] std::span<const remembered_contact> entries() const { return entries_; }
  [[nodiscard]] std::size_t bytes() const {
    return entries_.capacity() * sizeof(remembered_contact) +
           slots_.capacity() * sizeof(std::uint32_t);
  }

 private:
  void insert(std::size_t number) {
    const auto mask = slots_.size() - 1;
    auto s = entries_[number - 1].key.hash() & mask;
    while (slots_[s] != 0) s = (s + 1) & mask;
    slots_[s] = static_cast<std::uint32_t>(number);
  }
  void grow() {
    slots_.assign(std::bit_ceil(4 * entries_.size() + 16), 0);
    for (std::size_t n = 1; n <= entries_.size(); ++n) insert(n);
  }

  std::vector<remembered_contact> entries_;
  std::vector<std::uint32_t> slots_;  ///< number of the entry, from 1; 0 is empty
};

}  // namespace talus::detail
