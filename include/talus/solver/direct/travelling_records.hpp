#pragma once
// Records that ranks pass on to each other until each rank has those that it needs.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/id.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// A small set of ids, ascending.
class sorted_ids {
 public:
  [[nodiscard]] bool contains(system_id id) const {
    return std::binary_search(ids_.begin(), ids_.end(), id);
  }
  /// Returns whether it is new.
  bool insert(system_id id) {
    system_id* const at = std::lower_bound(ids_.begin(), ids_.end(), id);
    if (at != ids_.end() && *at == id) return false;
    ids_.insert(at, id);
    return true;
  }
  [[nodiscard]] const system_id* begin() const { return ids_.begin(); }
  [[nodiscard]] const system_id* end() const { return ids_.end(); }

 private:
  plain_vector<system_id> ids_;
};

/// Each rank begins with records of its own, and with lines to other ranks, which have lines to it.
/// In each round the records that a neighbour needs, and does not have, travel along each open
/// line. A line is closed when what has travelled along it is complete: both ends see that in the
/// same round, so that no rank waits for another one, and nothing is collective.
class travelling_records {
 public:
  struct line {
    int rank = 0;
    bool open = true;
    sorted_ids sent;  ///< in either direction
  };
  std::map<system_id, byte_buffer> all;
  std::vector<line> lines;

  void clear() { all.clear(), lines.clear(); }
  /// `needs(line, f)` calls f(name) for the records that the other end needs, as far as they are
  /// here; `arrived(name, bytes, line)` follows for each new one; `complete(line)` depends on
  /// `sent` alone.
  template <class Needs, class Complete, class Arrived, class Exchange>
  void exchange_all(Needs&& needs, Complete&& complete, Arrived&& arrived, Exchange&& exchange) {
    std::vector<neighbour_message> messages;
    while (true) {
      messages.clear();
      std::vector<std::size_t> of;
      for (std::size_t n = 0; n < lines.size(); ++n) {
        line& l = lines[n];
        if (!l.open) continue;
        of.push_back(n);
        byte_buffer& bytes = messages.emplace_back(neighbour_message{.rank = l.rank}).out;
        byte_writer out(bytes);
        needs(n, [&](system_id name) {
          const auto at = all.find(name);
          if (at == all.end() || !l.sent.insert(name)) return;
          out.put(name);
          out.put(std::span<const std::byte>(at->second));
        });
      }
      if (of.empty()) return;
      exchange(messages);
      for (std::size_t k = 0; k < of.size(); ++k) {
        line& l = lines[of[k]];
        byte_reader in(messages[k].in);
        while (!in.empty()) {
          const auto name = in.get<system_id>();
          const auto bytes = in.get_bytes(in.get<std::size_t>());
          l.sent.insert(name);  // it has that
          const auto [at, is_new] = all.try_emplace(name);
          if (!is_new) continue;
          at->second.assign(bytes.begin(), bytes.end());
          arrived(name, at->second, of[k]);
        }
      }
      for (const std::size_t n : of) lines[n].open = !complete(n);
    }
  }
};

}  // namespace talus::detail
