#pragma once
// The contacts of jointed bodies with what cannot move, on all ranks of an island of joints.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "talus/constraint/joint_in_list.hpp"
#include "talus/core/bytes.hpp"
#include "talus/core/each.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/ghosts/shared_joints.hpp"
#include "talus/solver/direct/supported_loads.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

template <class Scenario>
class joint_supports {
  using state_type = world_state<Scenario>;

 public:
  explicit joint_supports(state_type& s) : s_(s), jointed_(s.solver.bodies.size(), 0) {
    for (const joint_end& x : s.joints.ends)
      if (x.own && x.moves) jointed_[static_cast<std::size_t>(x.number)] = 1;
  }

  plain_vector<joint_support> all;  ///< sorted

  /// Collects the supports of this rank and of the other ranks of its islands.
  template <class Lists>
  void gather(const Lists& lists) {
    each_contact_list(lists, [&](const auto& list) {
      list.each_keyed([&](const auto& c, const contact_key& key) {
        const std::int32_t mover = mover_of(c);
        if (mover < 0) return;
        joint_support x;
        x.body = mover, x.place = own_++, x.key = key, x.friction = c.mu();
        x.axes = c.axes(), x.arm = c.lever_a(), x.impulse = c.impulse();
        const auto& body = s_.solver.bodies[static_cast<std::size_t>(mover)];
        const vec3 u = c.relative_velocity(s_.solver);
        x.slides = portable::hypot(u[1], u[2]) >
                   small * (v_of(body).norm() + s_.solver.speed + x.arm.norm() * w_of(body).norm());
        if (mover != c.a) x.arm = c.lever_b(), x.axes = -x.axes, x.impulse = -x.impulse;
        all.push_back(x);
      });
    });
    std::sort(all.begin(), all.end());
    if constexpr (!state_type::link_type::alone) share();
  }
  /// Gives the contacts of this rank that share loads their impulses; all others keep their bits.
  /// The bodies keep their velocities.
  template <class Lists>
  void put(Lists& lists) {
    plain_vector<const joint_support*> changed(own_, nullptr);
    for (const joint_support& x : all)
      if (x.place != joint_support::elsewhere && x.shares) changed[x.place] = &x;
    std::uint32_t next = 0;
    each_contact_list(lists, [&](auto& list) {
      list.edit_keyed([&](auto& c, const contact_key&) {
        const std::int32_t mover = mover_of(c);
        if (mover < 0) return;
        const joint_support* x = changed[next++];
        if (x != nullptr) c.load_impulse(mover == c.a ? x->impulse : -x->impulse);
      });
    });
  }

 private:
  static constexpr real small = 1e-6;  ///< part of a speed, above which a contact slides

  template <class Lists, class F>
  static void each_contact_list(Lists& lists, F&& f) {
    each_of(lists, [&](auto& list) {
      if constexpr (!is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>) f(list);
    });
  }
  /// The jointed body of a contact with something that cannot move, or -1.
  template <class Contact>
  [[nodiscard]] std::int32_t mover_of(const Contact& c) const {
    const auto jointed = [&](std::int32_t k) { return jointed_[static_cast<std::size_t>(k)] != 0; };
    if constexpr (Contact::paired) {
      const auto moves = [&](std::int32_t k) {
        return s_.solver.bodies[static_cast<std::size_t>(k)].inverse_mass != 0;
      };
      if (moves(c.a) && moves(c.b)) return -1;
      if (jointed(c.b)) return c.b;
    }
    return jointed(c.a) ? c.a : -1;
  }
  void share() {
    plain_vector<joint_support> far;
    const auto number = [&](std::uint32_t k) { return s_.joints.ends[k].number; };
    exchange_jointed(
        s_,
        [&](std::uint32_t k, byte_writer& out) {
          const auto less = [](const joint_support& x, const joint_support& y) {
            return x.body < y.body;
          };
          joint_support like;
          like.body = number(k);
          const auto [first, last] = std::equal_range(all.begin(), all.end(), like, less);
          out.put(std::span<const joint_support>(first, last));
        },
        [&](std::uint32_t k, byte_reader& in) {
          for (joint_support x : in.template get_all<joint_support>()) {
            if (k == joint_partner::ignored) continue;
            x.body = number(k), x.place = joint_support::elsewhere;
            far.push_back(x);
          }
        });
    for (const joint_support& x : far) all.push_back(x);
    std::sort(all.begin(), all.end());
  }

  state_type& s_;
  plain_vector<char> jointed_;  ///< the bodies of joints that are owned here, by solver's number
  std::uint32_t own_ = 0;
};

}  // namespace talus::detail
