#pragma once
// Warm starting: contacts take up the impulses that they had in the last step.
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "talus/contact/history.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A kind of contact of which a pair of bodies has several.
template <class Contact>
concept comes_in_patches = Contact::patches;

/// What the history keeps of one pair of bodies: as many entries in a row, or found by key.
class kept_pair {
 public:
  kept_pair(const contact_history& history, const contact_key& key, const history_place* place)
      : history_(history), key_(key), searched_(place == nullptr) {
    if (searched_ || *place == history_place::none) return;
    row_ = history.row(*place, key);
    searched_ = row_.empty();
  }
  [[nodiscard]] const vec3* find(const contact_key& key) const {
    if (searched_) return history_.find(key);
    for (const remembered_contact& old : row_)
      if (old.key.feature == key.feature) return &old.memory;
    return nullptr;
  }
  template <class F>
  void each(F&& f) const {
    if (searched_) return history_.each_of_pair(key_, f);
    for (const remembered_contact& old : row_) f(old);
  }

 private:
  const contact_history& history_;
  const contact_key& key_;
  std::span<const remembered_contact> row_;
  bool searched_;
};

/// Hands what points of a patch bore that are no more to those that are new, in equal parts: while
/// a body slides or rocks, the parts that meet change, but hardly the load. `keys` and `contacts`
/// are those of one pair.
template <class Contact>
void inherit(const kept_pair& kept, std::span<const contact_key> keys,
             std::span<Contact> contacts) {
  std::array<const remembered_contact*, 16> gone;
  std::size_t size = 0, heirs = 0;
  kept.each([&](const remembered_contact& old) {
    if (size < gone.size() && std::find(keys.begin(), keys.end(), old.key) == keys.end())
      gone[size++] = &old;
  });
  if (size == 0 || size == gone.size()) return;
  // In an order that does not depend on where they are remembered: ranks must agree to the bit.
  std::sort(gone.begin(), gone.begin() + size,
            [](auto* x, auto* y) { return x->key.feature < y->key.feature; });
  vec3 sum{0, 0, 0};
  for (std::size_t k = 0; k < size; ++k) sum += gone[k]->memory;
  for (const auto& key : keys) heirs += kept.find(key) == nullptr;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (kept.find(keys[i]) == nullptr) contacts[i].warm(sum / static_cast<real>(heirs));
}

/// Lets each contact start from the impulse that is remembered for its key.
template <class Contact>
void recall(const contact_history& history, const plain_vector<contact_key>& keys,
            const plain_vector<history_place*>& places, plain_vector<Contact>& contacts) {
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    const kept_pair kept(history, keys[first], places[first]);
    bool lost = false;
    for (; last < contacts.size() && keys[last].same_pair(keys[first]); ++last) {
      if (const vec3* p = kept.find(keys[last]))
        contacts[last].warm(*p);
      else
        lost = true;
    }
    if constexpr (comes_in_patches<Contact>)
      if (lost)
        inherit(kept, std::span(keys).subspan(first, last - first),
                std::span(contacts).subspan(first, last - first));
  }
}

template <class Contacts>
[[nodiscard]] vec3 impulse_of(const Contacts& contacts, std::size_t i) {
  if constexpr (requires { contacts.impulse(i); })
    return contacts.impulse(i);
  else
    return contacts[i].impulse();
}

/// The reverse; notes for each pair where its contacts are kept.
template <class Contacts>
void remember(contact_history& history, const plain_vector<contact_key>& keys,
              const plain_vector<history_place*>& places, const Contacts& contacts) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (places[i] != nullptr && (i == 0 || places[i] != places[i - 1]))
      *places[i] = history.next_place();
    history.add(keys[i], impulse_of(contacts, i));
  }
}

}  // namespace talus::detail
