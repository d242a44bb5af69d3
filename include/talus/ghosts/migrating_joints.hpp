#pragma once
// How joints migrate with their bodies, and how the owner of a fixed body follows its joints.
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Adds to each message the joints of the bodies that leave in it: destination(id) is the index of
/// the message, or their number. After a step the joints that act here go to the ranks that own
/// their fixed bodies, too. Returns whether this rank expects such joints.
template <class Scenario, class Destination>
bool send_joints(world_state<Scenario>& s, bool after_step, Destination&& destination) {
  const std::size_t messages = s.neighbour_messages.size();
  const auto message_to = [&](int rank) {
    std::size_t n = 0;
    while (n < messages && s.neighbour_messages[n].rank != rank) ++n;
    return n;
  };
  bool expects = false;
  s.joints.each_kind([&](const auto& of_kind) {
    using record = typename std::remove_cvref_t<decltype(of_kind)>::record;
    std::vector<plain_vector<record>> to(messages);
    for (const record& r : of_kind.records) {
      const auto send = [&](std::size_t n) {
        if (n < messages && (to[n].empty() || !(to[n].back().key == r.key))) to[n].push_back(r);
      };
      send(destination(r.key.a)), send(destination(r.key.b));
      if (!after_step) continue;
      if (r.follower >= 0) send(message_to(r.follower));
      expects = expects || r.follows;
    }
    for (std::size_t n = 0; n < messages; ++n)
      byte_writer(s.neighbour_messages[n].out).put(std::span<const record>(to[n]));
  });
  return expects;
}
/// Returns whether there were any.
template <class Scenario>
bool receive_joints(world_state<Scenario>& s, byte_reader& in) {
  bool any = false;
  s.joints.each_kind([&](auto& of_kind) {
    using record = typename std::remove_cvref_t<decltype(of_kind)>::record;
    for (record& r : in.get_all<record>()) r.follows = false, of_kind.add(r), any = true;
  });
  if (any) s.joints.changed();
  return any;
}
/// Removes the joints of bodies that are all owned elsewhere, and after a step those of fixed
/// bodies that no rank has sent: they have broken.
template <class Scenario>
void keep_own_joints(world_state<Scenario>& s, bool after_step) {
  const plain_vector<joint_end> ends = find_joint_ends(s);
  const jointed_ids ids = s.joints.ids();
  s.joints.each_kind([&](auto& of_kind) {
    std::size_t kept = 0;
    for (auto& r : of_kind.records) {
      const joint_end &a = ends[ids.find(r.key.a)], &b = ends[ids.find(r.key.b)];
      if ((!a.own && !b.own) || (after_step && r.follows)) continue;
      find_holders(r, a, b);
      of_kind.records[kept++] = r;
    }
    of_kind.records.resize(kept);
  });
  s.joints.changed();
}

}  // namespace talus::detail
