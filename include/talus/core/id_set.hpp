#pragma once
// A set of ids: open addressing with at least twice as many slots as members (Knuth, The Art of
// Computer Programming, volume 3, 6.4), so that a look-up costs about as much as reading the id.
#include <bit>
#include <cstddef>

#include "talus/core/id.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

class id_set {
 public:
  /// Reserves slots for that many members.
  explicit id_set(std::size_t members)
      : places_(std::bit_ceil(2 * members + 2), no_id),
        shift_(64 - std::countr_zero(places_.size())) {}

  /// Returns false if the id was already a member.
  bool insert(system_id id) {
    system_id& place = places_[find(id)];
    if (place == id) return false;
    place = id;
    return true;
  }
  [[nodiscard]] bool contains(system_id id) const { return places_[find(id)] == id; }

 private:
  /// The slot of an id, or the empty slot for it.
  [[nodiscard]] std::size_t find(system_id id) const {
    std::size_t at = (value_of(id) * 0x9e3779b97f4a7c15ull) >> shift_;
    while (places_[at] != id && places_[at] != no_id) at = (at + 1) & (places_.size() - 1);
    return at;
  }

  plain_vector<system_id> places_;
  int shift_;
};

}  // namespace talus::detail
