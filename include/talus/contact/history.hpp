#pragma once
// The memory of contacts from one step to the next: impulses of hard ones, for warm starting,
// springs of soft ones. It migrates with the bodies.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "talus/contact/key.hpp"
#include "talus/contact/place.hpp"
#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

template <class Memory>
struct kept_contact {
  contact_key key;
  Memory memory;  ///< of a hard contact: the impulse on body a, world frame
};

/// Contacts of the last step, found by key (open addressing) or by their place. The hash table is
/// built at the first search by key.
template <class Memory>
class history_of {
 public:
  using memory = Memory;
  using entry = kept_contact<Memory>;

  void clear() { reset(0); }
  /// Makes room for `n` contacts; call before adding. The first `kept` stay.
  void reset(std::size_t n, std::size_t kept = 0) {
    entries_.shorten(entries_.size() - kept);
    // With some slack, so that a slowly growing number of contacts does not allocate in each step.
    if (n > entries_.capacity()) entries_.reserve(n + n / 8);
    arrived_ = nothing;
    indexed_ = false, places_hold_ = false, unchanged_ = false;
  }
  /// Whether the contacts are those of the last step: nothing has changed since their solver called
  /// hold().
  [[nodiscard]] bool unchanged() const { return unchanged_; }
  void hold() { unchanged_ = true; }
  /// Whether every place that the neighbour list holds is that of the contact of its pair: nothing
  /// was added since the step that recorded them. Otherwise keys are compared.
  [[nodiscard]] bool places_hold() const { return places_hold_; }
  /// A step has recorded all contacts of the neighbour list.
  void hold_places() { places_hold_ = true; }
  [[gnu::always_inline]] inline void add(const contact_key& key, const Memory& memory) {
    entries_.push_back({key, memory});
    places_hold_ = false, unchanged_ = false;
    if (indexed_) [[unlikely]]
      index_last();
  }
  /// Adds room for `n` contacts, which the caller fills in, or removes again with drop_last().
  [[nodiscard, gnu::always_inline]] inline entry* add_some(std::size_t n) {
    indexed_ = false, unchanged_ = false;
    return entries_.extend(n);
  }
  [[gnu::always_inline]] inline void drop_last(std::size_t n) { entries_.shorten(n); }
  /// Adds the memory of a contact of a body that has arrived from another rank, unless another rank
  /// has sent it already.
  void add_arrived(const contact_key& key, const Memory& memory) {
    arrived_ = std::min(arrived_, entries_.size());
    if (entries_.size() - arrived_ > few) {
      if (find(key) != nullptr) return;
    } else {
      for (std::size_t i = arrived_; i < entries_.size(); ++i)
        if (entries_[i].key == key) return;
    }
    add(key, memory);
  }
  /// Resets the memory of contacts of a body. They keep their places.
  [[gnu::cold]] void forget(system_id body) {
    unchanged_ = false;
    for (entry& e : entries_)
      if (e.key.a == body || e.key.b == body) {
        if constexpr (requires { Memory::Zero(); })
          e.memory = Memory::Zero();
        else
          e.memory = {};
      }
  }
  /// The place to search for contacts of a pair that had none here and now has a body that arrived.
  [[nodiscard]] history_place place_of_arrivals() const {
    const std::size_t count = entries_.size() - std::min(arrived_, entries_.size());
    return count == 0     ? history_place::none
           : count <= few ? history_place::arrived
                          : history_place::unknown;
  }
  /// The place of contacts of a pair that came from another rank, or none.
  [[nodiscard]] history_place find_arrived(const contact_key& pair) const {
    for (std::size_t i = arrived_; i < entries_.size(); ++i)
      if (entries_[i].key.same_pair(pair)) return static_cast<history_place>(i);
    return history_place::none;
  }
  /// The place of the contact that is added next.
  [[nodiscard]] history_place next_place() const {
    return static_cast<history_place>(entries_.size());
  }
  /// The contacts of a pair that were added consecutively from `place` on.
  [[nodiscard]] std::span<const entry> row(history_place place, const contact_key& pair) const {
    const auto first = static_cast<std::size_t>(place);
    if (first >= entries_.size()) return {};
    const std::size_t end =
        first < arrived_ ? std::min(arrived_, entries_.size()) : entries_.size();
    std::size_t last = first;
    while (last < end && entries_[last].key.same_pair(pair)) ++last;
    return std::span(entries_).subspan(first, last - first);
  }
  /// The memory of the contact stored there, or null if it is that of another.
  [[nodiscard]] [[gnu::always_inline]] inline const Memory* at(history_place place,
                                                               const contact_key& key) const {
    const auto i = static_cast<std::size_t>(place);
    return i < entries_.size() && entries_[i].key == key ? &entries_[i].memory : nullptr;
  }
  /// The memory of a contact from the last step, or null if it is new. Contacts of a pair are
  /// recorded consecutively, and a place that has lost its pair is replaced by a search by key.
  [[nodiscard]] const Memory* former(history_place place, const contact_key& key) const {
    return memory_of(former_entry(place, key));
  }
  /// The key and the memory of a contact from the last step, or null if the contact is new.
  [[nodiscard]] const entry* former_entry(history_place place, const contact_key& key) const {
    if (place == history_place::none) return nullptr;
    const auto of_pair = row(place, key);
    if (of_pair.empty()) return find_entry(key);
    for (const entry& e : of_pair)
      if (e.key.feature == key.feature) return &e;
    return nullptr;
  }
  /// The entry at a place of the neighbour list if places_hold(), or null if it is a mark.
  [[nodiscard, gnu::always_inline]] inline const entry* at(history_place place) const {
    const auto n = static_cast<std::size_t>(place);
    return n < entries_.size() ? &entries_[n] : nullptr;
  }
  /// Loads the contacts of a pair that row() is asked for soon.
  [[gnu::always_inline]] inline void prefetch(history_place place) const {
    const auto first = static_cast<std::size_t>(place);
    if (first >= entries_.size()) return;
    const char* const line = reinterpret_cast<const char*>(entries_.data() + first);
    __builtin_prefetch(line), __builtin_prefetch(line + sizeof(entry) - 1);
  }
  /// The memory of the contact from the last step, or null if it is new.
  [[nodiscard]] const Memory* find(const contact_key& key) const {
    return memory_of(find_entry(key));
  }
  /// Calls f(entry) for all contacts of a pair.
  template <class F>
  void each_of_pair(const contact_key& pair, F&& f) const {
    if (entries_.empty()) return;
    if (!indexed_) index();
    const auto mask = slots_.size() - 1;
    for (auto s = pair.hash() & mask; slots_[s] != 0; s = (s + 1) & mask)
      if (entries_[slots_[s] - 1].key.same_pair(pair)) f(entries_[slots_[s] - 1]);
  }
  [[nodiscard]] std::span<const entry> entries() const { return entries_; }
  /// To change memories; keys stay.
  [[nodiscard]] std::span<entry> entries() {
    unchanged_ = false;
    return entries_;
  }
  [[nodiscard]] std::size_t bytes() const {
    return entries_.capacity() * sizeof(entry) + slots_.capacity() * sizeof(std::uint32_t);
  }

 private:
  [[nodiscard]] static const Memory* memory_of(const entry* e) {
    return e == nullptr ? nullptr : &e->memory;
  }
  [[nodiscard]] const entry* find_entry(const contact_key& key) const {
    if (entries_.empty()) return nullptr;
    if (!indexed_) index();
    const auto mask = slots_.size() - 1;
    for (auto s = key.hash() & mask; slots_[s] != 0; s = (s + 1) & mask)
      if (entries_[slots_[s] - 1].key == key) return &entries_[slots_[s] - 1];
    return nullptr;
  }
  [[gnu::noinline]] void index_last() {
    if (2 * entries_.size() > slots_.size())
      index();
    else
      insert(entries_.size());
  }
  void insert(std::size_t number) const {
    const auto mask = slots_.size() - 1;
    auto s = entries_[number - 1].key.hash() & mask;
    while (slots_[s] != 0) s = (s + 1) & mask;
    slots_[s] = static_cast<std::uint32_t>(number);
  }
  void index() const {
    const auto wanted = std::bit_ceil(2 * entries_.size() + 16);
    if (slots_.size() < wanted || slots_.size() > 8 * wanted)
      slots_.assign(wanted, 0);
    else
      std::fill(slots_.begin(), slots_.end(), 0);
    for (std::size_t n = 1; n <= entries_.size(); ++n) insert(n);
    indexed_ = true;
  }

  static constexpr std::size_t nothing = ~std::size_t{0};
  static constexpr std::size_t few = 200;  ///< are searched linearly

  plain_vector<entry> entries_;
  std::size_t arrived_ = nothing;  ///< the first entry from another rank
  bool places_hold_ = false;
  bool unchanged_ = false;
  mutable bool indexed_ = false;
  mutable plain_vector<std::uint32_t> slots_;  ///< index of the entry, from 1; 0 is empty
};

/// The history of hard contacts.
using contact_history = history_of<vec3>;
using stored_contact = kept_contact<vec3>;

}  // namespace talus::detail
