#pragma once
// The memories that an interaction law keeps of contacts, for features and observers.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <vector>

#include "talus/contact/history.hpp"
#include "talus/state/state.hpp"
#include "talus/world/each_contact.hpp"

namespace talus {

/// What a law keeps of a contact. A body that this rank does not know has the number
/// `unknown_body`.
template <class Memory>
struct contact_memory {
  static constexpr std::size_t unknown_body = ~std::size_t{0};

  system_id a = no_id, b = no_id;  ///< the bodies; b may be global
  std::uint64_t feature = 0;       ///< identifies the point within the pair
  std::size_t body_a = unknown_body, body_b = unknown_body;  ///< indices of all bodies known here
  /// True on one rank for each contact: for sums over contacts.
  bool counts_here = true;
  Memory& memory;
};

namespace detail {

/// Entries of a history, in the order of their keys, each key once.
template <class Entry>
void sort_by_key(std::vector<Entry*>& entries) {
  const auto order = [](const Entry* e) { return std::tie(e->key.a, e->key.b, e->key.feature); };
  // If an entry came from another rank too, the first one counts, as in history_of::find.
  std::sort(entries.begin(), entries.end(), [&](const Entry* x, const Entry* y) {
    return order(x) < order(y) || (x->key == y->key && x < y);
  });
  entries.erase(std::unique(entries.begin(), entries.end(),
                            [](const Entry* x, const Entry* y) { return x->key == y->key; }),
                entries.end());
}

/// Calls f(contact_memory) for those entries that touch a body owned here.
template <class Law, class Scenario, class Entry, class F>
void each_memory_of(const body_places<Scenario>& places, const std::vector<Entry*>& entries,
                    F&& f) {
  using law = typename Scenario::contact_law::law;
  for (Entry* e : entries) {
    bool own[2] = {false, false}, moves[2] = {false, false};
    std::size_t number[2];
    for (const int k : {0, 1}) {
      const std::uint32_t at = places.number_of(k == 0 ? e->key.a : e->key.b);
      number[k] = contact_memory<typename Law::memory>::unknown_body;
      if (at == id_table::unknown) continue;
      number[k] = at;
      places.visit_number(at, [&](const auto& store, std::size_t i, bool global) {
        moves[k] = !global && !store.fixed(i);
        own[k] = moves[k] && i < store.locals;
      });
    }
    if (!own[0] && !own[1]) continue;
    auto& memory = law::template of<Law>(e->memory);
    using memory_type = std::remove_reference_t<decltype(memory)>;
    f(contact_memory<memory_type>{e->key.a, e->key.b, e->key.feature, number[0], number[1],
                                  own[0] || !moves[0], memory});
  }
}

}  // namespace detail
}  // namespace talus
