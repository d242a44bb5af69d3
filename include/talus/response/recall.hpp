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

/// Hands what points of a patch bore that are no more to those that are new, in equal parts: while
/// a body slides or rocks, the parts that meet change, but hardly the load. `keys` and `contacts`
/// are those of one pair.
template <class Contact>
void inherit(const contact_history& history, std::span<const contact_key> keys,
             std::span<Contact> contacts) {
  std::array<const remembered_contact*, 16> gone;
  std::size_t size = 0, heirs = 0;
  history.each_of_pair(keys[0], [&](const remembered_contact& old) {
    if (size < gone.size() && std::find(keys.begin(), keys.end(), old.key) == keys.end())
      gone[size++] = &old;
  });
  if (size == 0 || size == gone.size()) return;
  // In an order that does not depend on where they are remembered: ranks must agree to the bit.
  std::sort(gone.begin(), gone.begin() + size,
            [](auto* x, auto* y) { return x->key.feature < y->key.feature; });
  vec3 sum{0, 0, 0};
  for (std::size_t k = 0; k < size; ++k) sum += gone[k]->memory;
  for (const auto& key : keys) heirs += history.find(key) == nullptr;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (history.find(keys[i]) == nullptr) contacts[i].warm(sum / static_cast<real>(heirs));
}

/// Lets each contact start from the impulse that is remembered for its key.
template <class Contact>
void recall(const contact_history& history, const plain_vector<contact_key>& keys,
            plain_vector<Contact>& contacts) {
  for (std::size_t first = 0, last = 0; first < contacts.size(); first = last) {
    bool lost = false;
    for (; last < contacts.size() && keys[last].same_pair(keys[first]); ++last) {
      if (const vec3* p = history.find(keys[last]))
        contacts[last].warm(*p);
      else
        lost = true;
    }
    if constexpr (comes_in_patches<Contact>)
      if (lost)
        inherit(history, std::span(keys).subspan(first, last - first),
                std::span(contacts).subspan(first, last - first));
  }
}

}  // namespace talus::detail
