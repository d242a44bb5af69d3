#pragma once
// features<sleeping>: one value for all of an island of joints that lies on several ranks, so that
// it falls asleep, and wakes, on all of them in one step.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/ghosts/joint_groups.hpp"
#include "talus/ghosts/shared_joints.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Replaces values[root] of each island of this rank by the lowest value of all islands on other
/// ranks that joints connect with it. Joints connect two movable bodies if both are asleep, or if
/// both are awake. `root_of(number, end)` is the island of a body, which joint_table::ids()
/// numbers. The ranks of such islands call this at the same time; no call is collective.
template <class Scenario, class RootOf>
void take_lowest_over_joints(world_state<Scenario>& s, bool asleep, RootOf&& root_of,
                             plain_vector<float>& values) {
  if constexpr (world_state<Scenario>::link_type::alone || !world_state<Scenario>::has_joints) {
    (void)s, (void)asleep, (void)root_of, (void)values;
  } else {
    using groups_type = joint_groups<Scenario>;
    constexpr std::uint32_t none = ~std::uint32_t{0};
    const jointed_ids& ids = s.joints.ids();
    const plain_vector<joint_end> ends = find_joint_ends(s);
    plain_vector<typename groups_type::border> borders;
    s.joints.each_kind([&](const auto& of_kind) {
      for (const auto& r : of_kind.records) {
        const std::size_t a = ids.find(r.key.a), b = ids.find(r.key.b);
        const joint_end &x = ends[a], &y = ends[b];
        if (!x.movable() || !y.movable() || x.own == y.own) continue;
        if (x.asleep != asleep || y.asleep != asleep) continue;
        borders.push_back({static_cast<std::uint32_t>(x.own ? root_of(a, x) : root_of(b, y)),
                           x.own ? y.owner : x.owner, x.own ? r.key.a : r.key.b,
                           x.own ? r.key.b : r.key.a});
      }
    });
    if (borders.empty()) return;

    // A part is named by the first of its own bodies.
    plain_vector<std::uint32_t> part_of(values.size(), none), roots;
    plain_vector<system_id> parts;
    for (std::size_t k = 0; k < ends.size(); ++k) {
      if (!ends[k].own || !ends[k].movable() || ends[k].asleep != asleep) continue;
      const auto root = static_cast<std::uint32_t>(root_of(k, ends[k]));
      if (part_of[root] != none) continue;
      part_of[root] = static_cast<std::uint32_t>(parts.size());
      parts.push_back(ids.members[k].id), roots.push_back(root);
    }
    for (auto& b : borders) b.part = part_of[b.part];
    const auto exchange = [&](std::vector<neighbour_message>& m) { exchange_messages(s, m); };
    groups_type groups;
    groups.find(s.link->rank(), parts, borders, exchange);

    plain_vector<float> lowest(groups.groups().size(), std::numeric_limits<float>::infinity());
    const auto each_part = [&](auto&& f) {
      for (std::uint32_t k = 0; k < parts.size(); ++k)
        if (const std::int32_t g = groups.group_of(k); g >= 0)
          f(values[roots[k]], lowest[static_cast<std::size_t>(g)]);
    };
    each_part([](float own, float& all) { all = std::min(all, own); });
    std::map<int, plain_vector<std::size_t>> shared;  // groups, by ranks
    for (std::size_t g = 0; g < lowest.size(); ++g)
      for (const int rank : groups.groups()[g].ranks)
        if (rank != s.link->rank()) shared[rank].push_back(g);
    std::vector<neighbour_message> messages;
    for (const auto& [rank, with] : shared) {
      byte_writer out(messages.emplace_back(neighbour_message{.rank = rank}).out);
      for (const std::size_t g : with) out.put(lowest[g]);
    }
    exchange(messages);
    for (const neighbour_message& m : messages) {
      byte_reader in(m.in);
      for (const std::size_t g : shared[m.rank]) lowest[g] = std::min(lowest[g], in.get<float>());
    }
    each_part([](float& own, float all) { own = all; });
  }
}

}  // namespace talus::detail
