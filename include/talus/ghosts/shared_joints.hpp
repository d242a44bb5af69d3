#pragma once
// Islands of joints that lie on several ranks. Each of these ranks gets all bodies and joints of
// the island, and solves the whole of it: in the same order, and so with the same bits.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/disjoint_sets.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/ghosts/joint_groups.hpp"
#include "talus/state/joints.hpp"
#include "talus/state/stage_clock.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Sends and receives messages between this rank and any others.
template <class Scenario>
void exchange_messages(world_state<Scenario>& s, std::vector<neighbour_message>& messages) {
  const stage_clock clock(s.seconds.exchange);
  s.link->start(messages);
  s.link->finish(messages);
}

/// One exchange with the partners: `pack(body, out)` and `unpack(body, in)` for the numbers of
/// joint_table::ends, the latter also for `joint_partner::ignored`.
template <class Scenario, class Pack, class Unpack>
void exchange_jointed(world_state<Scenario>& s, Pack&& pack, Unpack&& unpack) {
  if (s.joints.partners.empty()) return;
  std::vector<neighbour_message> messages;
  for (const joint_partner& p : s.joints.partners) {
    byte_writer out(messages.emplace_back(neighbour_message{.rank = p.rank}).out);
    for (const std::uint32_t k : p.sent) pack(k, out);
  }
  exchange_messages(s, messages);
  for (std::size_t n = 0; n < messages.size(); ++n) {
    byte_reader in(messages[n].in);
    for (const std::uint32_t k : s.joints.partners[n].received) unpack(k, in);
  }
}

/// After place_joints(): gathers what this rank needs of such islands.
template <class Scenario>
class joint_gathering {
  using state_type = world_state<Scenario>;
  using groups_type = joint_groups<Scenario>;
  struct reported_end {
    system_id id;
    joint_end end, before;
  };

 public:
  explicit joint_gathering(state_type& s)
      : s_(s), ids_(s.joints.ids()), ends_(s.joints.ends), own_(ends_.size()) {}

  void gather() {
    s_.joints.partners.clear(), s_.joints.far.clear();
    s_.joints.each_kind([](auto& of_kind) { of_kind.far.clear(), of_kind.far_rows.clear(); });
    find_parts();
    if (borders_.empty()) return;
    groups_.find(s_.link->rank(), parts_, borders_,
                 [&](std::vector<neighbour_message>& m) { exchange_messages(s_, m); });
    list_bodies();
    exchange();
    place_far();
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  [[nodiscard]] bool own(std::size_t k) const { return ends_[k].own && ends_[k].moves; }

  /// Calls f(record, a, b) for the joints that move a body owned here.
  template <class F>
  void each_joint(F&& f) {
    s_.joints.each_kind([&](auto& of_kind) { each_joint(of_kind, f); });
  }
  template <class OfKind, class F>
  void each_joint(OfKind& of_kind, F&& f) {
    for (const auto& r : of_kind.records) {
      const std::size_t a = ids_.find(r.key.a), b = ids_.find(r.key.b);
      if (own(a) || own(b)) f(r, a, b);
    }
  }
  void find_parts() {
    disjoint_sets sets(own_);
    each_joint([&](const auto&, std::size_t a, std::size_t b) {
      if (own(a) && own(b)) sets.join(a, b);
    });
    part_of_.assign(own_, none);
    plain_vector<std::uint32_t> part_of_root(own_, none);
    for (std::size_t k = 0; k < own_; ++k) {  // members are in the order of their ids
      if (!own(k)) continue;
      std::uint32_t& part = part_of_root[sets.root(k)];
      if (part == none) {
        part = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back(ids_.members[k].id);
      }
      part_of_[k] = part;
    }
    each_joint([&](const auto& r, std::size_t a, std::size_t b) {
      if (!ends_[a].moves || !ends_[b].moves || own(a) == own(b)) return;
      const std::size_t here = own(a) ? a : b, there = own(a) ? b : a;
      borders_.push_back({part_of_[here], ends_[there].owner, own(a) ? r.key.a : r.key.b,
                          own(a) ? r.key.b : r.key.a});
    });
  }
  /// The group of a joint, or -1.
  [[nodiscard]] std::int32_t group_of(std::size_t a, std::size_t b) const {
    return groups_.group_of(part_of_[own(a) ? a : b]);
  }

  /// The partners, and the bodies that each gets.
  void list_bodies() {
    const auto& groups = groups_.groups();
    std::vector<plain_vector<std::uint32_t>> bodies(groups.size());
    for (std::uint32_t k = 0; k < own_; ++k)
      if (part_of_[k] != none)
        if (const auto g = groups_.group_of(part_of_[k]); g >= 0)
          bodies[static_cast<std::size_t>(g)].push_back(k);
    each_joint([&](const auto&, std::size_t a, std::size_t b) {
      const auto g = group_of(a, b);
      if (g < 0) return;
      for (const std::size_t k : {a, b})
        if (!ends_[k].moves)
          bodies[static_cast<std::size_t>(g)].push_back(static_cast<std::uint32_t>(k));
    });
    plain_vector<int> ranks;
    for (const auto& g : groups)
      for (const int rank : g.ranks)
        if (rank != s_.link->rank()) ranks.push_back(rank);
    sort_values(ranks);
    ranks.resize(static_cast<std::size_t>(std::unique(ranks.begin(), ranks.end()) - ranks.begin()));
    for (const int rank : ranks) {
      joint_partner& p = s_.joints.partners.emplace_back();
      p.rank = rank;
      for (std::size_t g = 0; g < groups.size(); ++g)
        if (in_group(g, rank))
          for (const std::uint32_t k : bodies[g]) p.sent.push_back(k);
      sort_values(p.sent);
      p.sent.resize(
          static_cast<std::size_t>(std::unique(p.sent.begin(), p.sent.end()) - p.sent.begin()));
    }
  }
  [[nodiscard]] bool in_group(std::size_t g, int rank) const {
    const auto& ranks = groups_.groups()[g].ranks;
    return std::binary_search(ranks.begin(), ranks.end(), rank);
  }

  /// Bodies and joints. A joint comes from the rank that owns its first body that can move.
  void exchange() {
    std::vector<neighbour_message> messages;
    for (const joint_partner& p : s_.joints.partners) {
      byte_writer out(messages.emplace_back(neighbour_message{.rank = p.rank}).out);
      out.put(p.sent.size());
      for (const std::uint32_t k : p.sent) {
        reported_end x{ids_.members[k].id, ends_[k], {}};
        if constexpr (state_type::midpoint) x.before = s_.joints.before[k];
        out.put(x);
      }
      s_.joints.each_kind([&](auto& of_kind) {
        using record = typename std::remove_cvref_t<decltype(of_kind)>::record;
        plain_vector<record> told;
        each_joint(of_kind, [&](const record& r, std::size_t a, std::size_t b) {
          const auto g = group_of(a, b);
          if (g >= 0 && in_group(static_cast<std::size_t>(g), p.rank) &&
              own(ends_[a].moves ? a : b))
            told.push_back(r);
        });
        out.put(std::span<const record>(told.data(), told.size()));
      });
    }
    exchange_messages(s_, messages);
    for (std::size_t n = 0; n < messages.size(); ++n) {
      byte_reader in(messages[n].in);
      joint_partner& p = s_.joints.partners[n];
      for (auto count = in.get<std::size_t>(); count > 0; --count)
        p.received.push_back(number_of(in.get<reported_end>()));
      s_.joints.each_kind([&](auto& of_kind) {
        using record = typename std::remove_cvref_t<decltype(of_kind)>::record;
        for (const record& r : in.get_all<record>())
          if (const record* held = of_kind.find(r.key); held == nullptr || held->follows)
            of_kind.far.push_back(r);
      });
    }
  }
  std::uint32_t number_of(const reported_end& x) {
    const std::size_t known = s_.joints.find_end(x.id);
    if (known != jointed_ids::unknown)
      return x.end.moves ? static_cast<std::uint32_t>(known) : joint_partner::ignored;
    const auto k = static_cast<std::uint32_t>(ends_.size());
    auto& far = s_.joints.far;
    const plain_pair named{x.id, k};
    far.insert(std::upper_bound(far.begin(), far.end(), named), named);
    ends_.push_back(x.end);
    joint_end& end = ends_.back();
    end.own = false, end.at_border = false;
    end.number = static_cast<std::int32_t>(s_.solver.bodies.size());
    s_.solver.bodies.push_back({});
    if constexpr (state_type::midpoint) s_.joints.before.push_back(x.before);
    return k;
  }
  void place_far() {
    s_.joints.each_kind([&](auto& of_kind) {
      auto& far = of_kind.far;
      std::sort(far.begin(), far.end(), [](const auto& x, const auto& y) { return x.key < y.key; });
      for (auto& r : far) {
        const std::size_t a = s_.joints.find_end(r.key.a), b = s_.joints.find_end(r.key.b);
        if (a == jointed_ids::unknown || b == jointed_ids::unknown)
          fail<std::logic_error>(
              "rank {} has received a joint of bodies {} and {} without one of these",
              s_.link->rank(), r.key.a, r.key.b);
        typename std::remove_cvref_t<decltype(of_kind)>::row c{};
        place_rows(s_, c, r, ends_[a], ends_[b]);
        of_kind.far_rows.push_back(c);
      }
    });
  }

  state_type& s_;
  const jointed_ids& ids_;
  plain_vector<joint_end>& ends_;
  std::size_t own_;  ///< bodies of own joints
  plain_vector<system_id> parts_;
  plain_vector<std::uint32_t> part_of_;
  plain_vector<typename groups_type::border> borders_;
  groups_type groups_;
};

/// To be called after place_joints().
template <class Scenario>
void gather_joints(world_state<Scenario>& s) {
  if constexpr (!world_state<Scenario>::link_type::alone && solves_joints_directly<Scenario>)
    joint_gathering<Scenario>(s).gather();
}

/// The velocities of the bodies of such islands come from their owners; `first` in a step, also
/// what else the solver needs of them.
template <class Scenario>
void share_jointed_velocities(world_state<Scenario>& s, bool first) {
  using number = solved_scalar<Scenario>;
  auto& solver = s.solver;
  const auto& ends = s.joints.ends;
  const auto place = [&](std::uint32_t k) { return static_cast<std::size_t>(ends[k].number); };
  if (first) {
    exchange_jointed(
        s,
        [&](std::uint32_t k, byte_writer& out) {
          const std::size_t i = place(k);
          out.put(solver.bodies[i]);
          out.put(solver.has_tensor(i) ? solver.tensor(i) : mat3::Zero());
        },
        [&](std::uint32_t k, byte_reader& in) {
          const auto body = in.template get<solver_body_of<number>>();
          const auto tensor = in.template get<mat3>();
          if (k == joint_partner::ignored) return;
          const std::size_t i = place(k);
          solver.bodies[i] = body;
          if (i >= solver.first_tensor) solver.tensors[i - solver.first_tensor] = tensor;
          solver.shift[i] = {{0, 0, 0}, body.inverse_mass};
        });
    return;
  }
  exchange_jointed(
      s,
      [&](std::uint32_t k, byte_writer& out) {
        const auto& b = solver.bodies[place(k)];
        if (ends[k].moves) out.put(b.v), out.put(b.w);
      },
      [&](std::uint32_t k, byte_reader& in) {
        if (k == joint_partner::ignored || !ends[k].moves) return;
        auto& b = solver.bodies[place(k)];
        b.v = in.template get<vector3<number>>(), b.w = in.template get<vector3<number>>();
      });
}

}  // namespace talus::detail
