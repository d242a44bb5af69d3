#pragma once
// What a rank knows of the islands of its bodies: the figures of parts of these and other ranks.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/id.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/solver/direct/island_parts.hpp"
#include "talus/solver/direct/stalled_figures.hpp"
#include "talus/solver/direct/travelling_records.hpp"

namespace talus::detail {

/// Parts that are known to a rank, and the islands that they form.
class known_islands {
 public:
  struct island {
    std::vector<system_id> names;  ///< of its parts, ascending
    stalled_figures all;           ///< of all of them
    bool whole = true;             ///< all of them are known
  };

  void clear(const island_limits& limits) {
    limits_ = limits;
    known_.clear(), part_of_.clear(), forget_islands();
    unresolved_ = true;
  }
  /// Adds a part.
  void enter(const island_part& part) {
    part_of_[value_of(part.name)] = part.name;
    for (const auto& [own, other] : part.ties) part_of_[value_of(own)] = part.name;
    known_[part.name] = {part, {}};
    unresolved_ = true;
  }
  /// The parts that are known to form an island with this one; the same object for each of these,
  /// until enter() or clear().
  [[nodiscard]] const island& island_of(system_id name) {
    resolve();
    const auto [at, is_new] = island_of_.try_emplace(name);
    if (is_new) {
      const island& one = islands_.emplace_back(island_among(name, nullptr));
      for (const system_id other : one.names) island_of_[other] = &one;
    }
    return *island_of_.at(name);
  }
  /// Whether the islands of these parts are whole, or left out, if only these are known.
  [[nodiscard]] bool are_whole(const sorted_ids& names) {
    resolve();
    bool whole = true, left_out = false;
    std::uint32_t contacts = 0;
    for (const system_id name : names) {
      const known_part& part = known_.at(name);
      left_out |= part.about.figures.is_left_out(limits_);
      contacts += part.about.figures.contacts;
      whole = whole && !part.open &&
              std::all_of(part.touching.begin(), part.touching.end(),
                          [&](system_id other) { return names.contains(other); });
    }
    if (whole || (!left_out && contacts <= limits_.contacts)) return whole;
    sorted_ids seen;
    for (const system_id name : names) {
      if (seen.contains(name)) continue;
      const island one = island_among(name, &names);
      if (!one.whole && !one.all.is_left_out(limits_)) return false;
      for (const system_id other : one.names) seen.insert(other);
    }
    return true;
  }

  static byte_buffer packed(const island_part& part) {
    byte_buffer bytes;
    byte_writer out(bytes);
    out.put(part.name), out.put(part.figures);
    for (const auto& tie : part.ties) out.put(tie);
    return bytes;
  }
  static island_part unpacked(const byte_buffer& bytes) {
    byte_reader in(bytes);
    island_part part;
    part.name = in.get<system_id>();
    part.figures = in.get<stalled_figures>();
    while (!in.empty()) part.ties.push_back(in.get<plain_pair<system_id, system_id>>());
    return part;
  }
  /// A body of a part that is too large, in place of that part.
  static island_part large_part(system_id body) {
    island_part part;
    part.name = body, part.figures.left_out = true;
    return part;
  }

 private:
  /// A part that is known, and the parts that it touches as far as these are.
  struct known_part {
    island_part about;
    plain_vector<system_id> touching;
    bool open = true;  ///< it touches others, too
  };

  [[nodiscard]] island island_among(system_id name, const sorted_ids* only) const {
    island one;
    one.names.push_back(name);
    std::set<system_id> met{name};
    for (std::size_t n = 0; n < one.names.size(); ++n) {
      const known_part& part = known_.at(one.names[n]);
      one.all.add(part.about.figures);
      one.whole = one.whole && !part.open;
      for (const system_id other : part.touching)
        if (only != nullptr && !only->contains(other))
          one.whole = false;
        else if (met.insert(other).second)
          one.names.push_back(other);
    }
    std::sort(one.names.begin(), one.names.end());
    return one;
  }
  /// Finds what the known parts touch, if more are known than before.
  void resolve() {
    if (!std::exchange(unresolved_, false)) return;
    forget_islands();
    for (auto& [name, part] : known_) {
      if (!std::exchange(part.open, false)) continue;
      part.touching.clear();
      for (const auto& [own, other] : part.about.ties) {
        const auto at = part_of_.find(value_of(other));
        if (at == part_of_.end())
          part.open = true;
        else
          part.touching.push_back(at->second);
      }
      sort_values(part.touching);
      part.touching.erase(std::unique(part.touching.begin(), part.touching.end()),
                          part.touching.end());
    }
  }
  void forget_islands() { islands_.clear(), island_of_.clear(); }

  island_limits limits_;
  std::map<system_id, known_part> known_;
  bool unresolved_ = false;                               ///< what the known parts touch
  std::deque<island> islands_;                            ///< that were asked for
  std::map<system_id, const island*> island_of_;          ///< of their parts
  std::unordered_map<std::uint64_t, system_id> part_of_;  ///< of a body with ties
};

}  // namespace talus::detail
