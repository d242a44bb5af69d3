#pragma once
// Numbers of ids: where the thing with an id is in a list.
#include <cstddef>
#include <cstdint>

#include "talus/core/id.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/random.hpp"

namespace talus::detail {

/// Open addressing with linear probing.
class id_table {
 public:
  static constexpr std::uint32_t unknown = ~std::uint32_t{0};

  id_table() { reset(0); }
  /// A table of the ids `id_of(thing)` of all `things`, in the order of the things.
  template <class Things, class IdOf>
  id_table(const Things& things, IdOf&& id_of) {
    reset(things.size());
    for (const auto& thing : things) add(id_of(thing));
  }

  /// Empty, with room for `most` ids.
  void reset(std::size_t most) {
    std::size_t room = 16;
    while (room < 2 * most) room *= 2;
    slots_.assign(room, 0);
    ids_.clear();
    ids_.reserve(most);
  }
  /// The next number; an id that is there twice is found by its first one.
  void add(system_id id) {
    ids_.push_back(id);
    slots_[free_slot(id)] = static_cast<std::uint32_t>(ids_.size());
  }
  /// The number of an id, in the order of insertion from 0; `unknown` if it is absent.
  [[nodiscard]] std::uint32_t find(system_id id) const {
    for (std::size_t s = first_slot(id); slots_[s] != 0; s = next(s))
      if (ids_[slots_[s] - 1] == id) return slots_[s] - 1;
    return unknown;
  }
  [[nodiscard]] bool has(system_id id) const { return find(id) != unknown; }

 private:
  [[nodiscard]] std::size_t first_slot(system_id id) const {
    return mix(value_of(id)) & (slots_.size() - 1);
  }
  [[nodiscard]] std::size_t next(std::size_t slot) const {
    return (slot + 1) & (slots_.size() - 1);
  }
  [[nodiscard]] std::size_t free_slot(system_id id) const {
    std::size_t s = first_slot(id);
    while (slots_[s] != 0) s = next(s);
    return s;
  }
  plain_vector<std::uint32_t> slots_;
  plain_vector<system_id> ids_;
};

}  // namespace talus::detail
