#pragma once
// Which ranks an island of joints lies on. Ranks find it with messages to those that own the other
// bodies of their joints: no call is collective.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/neighbour_message.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"

namespace talus::detail {

/// The parts of islands: bodies of one rank that its own joints connect. A part has the lowest id
/// of its bodies as its name. Parts on two ranks are adjacent if a joint connects them. In each
/// round a rank tells the ranks of adjacent parts which parts of the island, with their adjacent
/// parts, it knows, each once. So after k rounds it knows all parts within a distance of k. Once a
/// rank knows all parts of an island, it knows the largest distance of two of them. That is the
/// number of rounds of the island, on all its ranks: until then a rank goes on telling.
/// (A template, so that programs without joints compile none of it.)
template <class Of>
class joint_groups {
 public:
  /// A joint of a body here and one of another rank.
  struct border {
    std::uint32_t part;
    std::int32_t rank;
    system_id own, other;
  };
  /// An island on several ranks.
  struct group {
    system_id name;           ///< lowest of its parts
    plain_vector<int> ranks;  ///< ascending, with this one
  };

  /// `exchange(messages)` sends and receives them. Parts have the names `parts`.
  template <class Exchange>
  void find(int own, const plain_vector<system_id>& parts, const plain_vector<border>& borders,
            Exchange&& exchange) {
    groups_.clear(), group_of_.assign(parts.size(), -1), known_.clear(), told_.clear();
    ranks_.clear();
    for (const border& b : borders) ranks_.push_back(b.rank);
    sort_values(ranks_);
    ranks_.resize(
        static_cast<std::size_t>(std::unique(ranks_.begin(), ranks_.end()) - ranks_.begin()));
    if (ranks_.empty()) return;
    name_neighbours(own, parts, borders, exchange);
    for (int round = 1; tell(round, parts, borders, exchange);) ++round;
    collect(parts);
  }
  /// By their names.
  [[nodiscard]] const std::vector<group>& groups() const { return groups_; }
  /// The group of a part, or -1.
  [[nodiscard]] std::int32_t group_of(std::uint32_t part) const { return group_of_[part]; }

 private:
  struct node {
    std::int32_t rank = -1;
    plain_vector<system_id> next;
  };
  struct extent {
    plain_vector<system_id> nodes;
    bool complete = true;
    int width = 0;  ///< the largest distance, if complete
  };

  template <class Exchange>
  void name_neighbours(int own, const plain_vector<system_id>& parts,
                       const plain_vector<border>& borders, Exchange&& exchange) {
    using named = plain_pair<system_id, system_id>;
    std::vector<neighbour_message> messages;
    for (const int rank : ranks_) {
      plain_vector<named> mine;
      for (const border& b : borders)
        if (b.rank == rank) mine.push_back({b.own, parts[b.part]});
      byte_writer(messages.emplace_back(neighbour_message{.rank = rank}).out)
          .put(std::span<const named>(mine));
    }
    exchange(messages);
    for (const border& b : borders) {
      node& n = known_[value_of(parts[b.part])];
      n.rank = own;
    }
    for (const neighbour_message& m : messages) {
      auto theirs = byte_reader(m.in).get_all<named>();
      std::sort(theirs.begin(), theirs.end());
      for (const border& b : borders) {
        if (b.rank != m.rank) continue;
        const auto at = std::lower_bound(theirs.begin(), theirs.end(), named{b.other, system_id{}});
        if (at == theirs.end() || at->first != b.other)
          fail<std::logic_error>("ranks {} and {} disagree about the joint of bodies {} and {}",
                                 own, m.rank, text(b.own), text(b.other));
        auto& next = known_[value_of(parts[b.part])].next;
        if (std::find(next.begin(), next.end(), at->second) == next.end())
          next.push_back(at->second);
      }
    }
  }

  /// All parts known to be connected with `from`, in the order of their distances; `last` is that
  /// of the last one. Returns whether the neighbours of all are known.
  bool walk(system_id from, plain_vector<system_id>& found, int& last) const {
    std::map<std::uint64_t, int> distance{{value_of(from), 0}};
    found.assign(1, from), last = 0;
    bool complete = true;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const auto at = known_.find(value_of(found[i]));
      last = distance[value_of(found[i])];
      if (at == known_.end()) {
        complete = false;
        continue;
      }
      for (const system_id id : at->second.next)
        if (distance.emplace(value_of(id), last + 1).second) found.push_back(id);
    }
    return complete;
  }
  [[nodiscard]] extent explore(system_id from) const {
    extent x;
    int last = 0;
    x.complete = walk(from, x.nodes, last);
    plain_vector<system_id> none;
    if (x.complete)
      for (const system_id id : x.nodes)
        (void)walk(id, none, last), x.width = std::max(x.width, last);
    return x;
  }

  /// One round. Returns whether there was anything to tell.
  template <class Exchange>
  bool tell(int round, const plain_vector<system_id>& parts, const plain_vector<border>& borders,
            Exchange&& exchange) {
    std::vector<extent> extents(parts.size());
    plain_vector<char> seen(parts.size(), 0);
    for (const border& b : borders)
      if (!seen[b.part]) extents[b.part] = explore(parts[b.part]), seen[b.part] = 1;
    std::vector<neighbour_message> messages;
    for (const int rank : ranks_) {
      plain_vector<std::uint64_t> news;
      bool open = false;
      for (const border& b : borders) {
        const extent& x = extents[b.part];
        if (b.rank != rank || (x.complete && x.width < round)) continue;
        open = true;
        for (const system_id id : x.nodes)
          if (known_.contains(value_of(id)) && told_[rank].emplace(value_of(id), true).second)
            news.push_back(value_of(id));
      }
      if (!open) continue;
      byte_writer out(messages.emplace_back(neighbour_message{.rank = rank}).out);
      out.put(news.size());
      for (const std::uint64_t id : news) {
        const node& n = known_.at(id);
        out.put(id), out.put(n.rank),
            out.put(std::span<const system_id>(n.next.data(), n.next.size()));
      }
    }
    if (messages.empty()) return false;
    exchange(messages);
    for (const neighbour_message& m : messages) {
      byte_reader in(m.in);
      for (auto count = in.get<std::size_t>(); count > 0; --count) {
        const auto id = in.get<std::uint64_t>();
        node n;
        n.rank = in.get<std::int32_t>();
        for (const system_id next : in.get_all<system_id>()) n.next.push_back(next);
        known_.emplace(id, std::move(n));
      }
    }
    return true;
  }

  void collect(const plain_vector<system_id>& parts) {
    std::map<std::uint64_t, plain_vector<std::uint32_t>> members;  // by the name of the group
    for (std::uint32_t k = 0; k < parts.size(); ++k) {
      if (known_.find(value_of(parts[k])) == known_.end()) continue;
      plain_vector<system_id> nodes;
      int last = 0;
      (void)walk(parts[k], nodes, last);
      std::uint64_t name = value_of(parts[k]);
      for (const system_id id : nodes) name = std::min(name, value_of(id));
      members[name].push_back(k);
    }
    for (const auto& [name, own] : members) {
      group& g = groups_.emplace_back();
      g.name = system_id{name};
      plain_vector<system_id> nodes;
      int last = 0;
      (void)walk(parts[own[0]], nodes, last);
      for (const system_id id : nodes) g.ranks.push_back(known_.at(value_of(id)).rank);
      sort_values(g.ranks);
      g.ranks.resize(
          static_cast<std::size_t>(std::unique(g.ranks.begin(), g.ranks.end()) - g.ranks.begin()));
      for (const std::uint32_t k : own)
        group_of_[k] = static_cast<std::int32_t>(groups_.size() - 1);
    }
  }

  std::vector<group> groups_;
  plain_vector<std::int32_t> group_of_;
  plain_vector<int> ranks_;
  std::map<std::uint64_t, node> known_;
  std::map<int, std::map<std::uint64_t, bool>> told_;  ///< by ranks
};

}  // namespace talus::detail
