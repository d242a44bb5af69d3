#pragma once
// Contact lists of any kind behind one interface: rarely used solvers need not be compiled for each
// kind of contact.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "talus/constraint/contact_impact.hpp"
#include "talus/constraint/island_contact.hpp"
#include "talus/constraint/joint_in_list.hpp"
#include "talus/constraint/solver_state.hpp"
#include "talus/contact/key.hpp"
#include "talus/core/each.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// The selected contacts of a list.
enum class contact_part : std::uint8_t { interior, boundary, foreign };

/// The bodies of a contact; b = -1 if that is a global one.
struct contact_ends {
  std::int32_t a, b;
};

/// The functions of a list of any kind. calls() of a list returns the address of its own.
template <class State>
struct contact_calls {
  std::size_t (*size)(void*, contact_part);
  void (*add_ends)(void*, contact_part, plain_vector<contact_ends>&);
  const contact_key& (*key)(void*, contact_part, std::size_t);
  island_contact (*contact)(void*, contact_part, std::size_t);
  void (*add_impulses)(void*, contact_part, std::span<const std::uint32_t>, plain_vector<vec3>&);
  void (*add_strikes)(void*, contact_part, std::span<const std::uint32_t>, plain_vector<char>&);
  void (*set)(void*, contact_part, std::size_t, const vec3&);
  void (*set_and_apply)(void*, std::size_t, const vec3&, State&);
  void (*set_at_boundary)(void*, std::size_t, const vec3&, State&);
  const plain_vector<plain_pair<std::size_t, real>>& (*sweep_watched)(void*, State&, real);
  real (*largest_correction)(void*);
};

template <class State>
class contact_access {
 public:
  template <class List>
  explicit contact_access(List& list) : list_(&list), calls_(List::calls()) {}

  [[nodiscard]] std::size_t size(contact_part p) const { return calls_->size(list_, p); }
  /// Appends the bodies of each contact.
  void add_ends(contact_part p, plain_vector<contact_ends>& to) const {
    calls_->add_ends(list_, p, to);
  }
  /// Calls f(its bodies, index) for each contact.
  template <class F>
  void each_ends(contact_part p, F&& f) const {
    plain_vector<contact_ends> all;
    add_ends(p, all);
    for (std::size_t i = 0; i < all.size(); ++i) f(all[i], i);
  }
  [[nodiscard]] const contact_key& key(contact_part p, std::size_t i) const {
    return calls_->key(list_, p, i);
  }
  [[nodiscard]] island_contact contact(contact_part p, std::size_t i) const {
    return calls_->contact(list_, p, i);
  }
  /// Appends the impulses of the contacts of these numbers on a, in the world. The numbers ascend.
  void add_impulses(contact_part p, std::span<const std::uint32_t> numbers,
                    plain_vector<vec3>& to) const {
    calls_->add_impulses(list_, p, numbers, to);
  }
  /// Appends whether the contacts of these numbers strike. The numbers ascend.
  void add_strikes(contact_part p, std::span<const std::uint32_t> numbers,
                   plain_vector<char>& to) const {
    calls_->add_strikes(list_, p, numbers, to);
  }
  /// Sets its impulse on a, in the world; the velocities are not changed.
  void set(contact_part p, std::size_t i, const vec3& impulse) const {
    calls_->set(list_, p, i, impulse);
  }
  /// Sets the impulse of an interior contact on a, in the world, and applies the change to the
  /// bodies.
  void set(std::size_t i, const vec3& impulse, State& s) const {
    calls_->set_and_apply(list_, i, impulse, s);
  }
  /// Sets the impulse of a boundary contact on a, in the world, and applies the change to the body
  /// owned by this rank.
  void set_at_boundary(std::size_t i, const vec3& impulse, State& s) const {
    calls_->set_at_boundary(list_, i, impulse, s);
  }
  /// A sweep that records the interior contacts that still change by more than `speed`: (index,
  /// change).
  const plain_vector<plain_pair<std::size_t, real>>& sweep_watched(State& s, real speed) const {
    return calls_->sweep_watched(list_, s, speed);
  }
  /// The largest correction rate, by its magnitude, of the interior contacts at rest.
  [[nodiscard]] real largest_correction() const { return calls_->largest_correction(list_); }

 private:
  void* list_;
  const contact_calls<State>* calls_;
};

template <class List>
[[nodiscard]] List& list_at(void* list) {
  return *static_cast<List*>(list);
}
/// Lists of solvers that watch a sweep have all functions, those of solvers by colours the others.
template <class List>
inline constexpr contact_calls<typename List::state> calls_for = [] {
  using state = typename List::state;
  contact_calls<state> calls{};
  calls.size = [](void* l, contact_part p) { return list_at<List>(l).size(p); };
  calls.add_ends = [](void* l, contact_part p, plain_vector<contact_ends>& to) {
    const std::size_t n = list_at<List>(l).size(p);
    to.reserve(to.size() + n);
    if constexpr (requires { list_at<List>(l).each_ends(p, [](std::int32_t, std::int32_t) {}); })
      list_at<List>(l).each_ends(p, [&](std::int32_t a, std::int32_t b) { to.push_back({a, b}); });
    else
      for (std::size_t i = 0; i < n; ++i) {
        const auto [a, b] = list_at<List>(l).bodies(p, i);
        to.push_back({a, b});
      }
  };
  calls.key = [](void* l, contact_part p, std::size_t i) -> const contact_key& {
    return list_at<List>(l).key(p, i);
  };
  calls.contact = [](void* l, contact_part p, std::size_t i) -> island_contact {
    const auto c = list_at<List>(l).contact(p, i);
    const vec3 lever_b = c.paired ? vec3(c.lever_b()) : vec3(0, 0, 0);
    island_contact one{c.a,     c.paired ? c.b : -1, c.axes(), c.lever_a(),
                       lever_b, c.target_velocity,   c.mu(),   c.impulse()};
    if constexpr (c.biased) {
      const vec3 bias = one.axes * c.bias;
      one.target_velocity += bias[0];
      one.drive = {-bias[1], -bias[2]};
    }
    one.correction_rate = c.correction_rate;
    return one;
  };
  if constexpr (requires(List & list) { list.each_numbered({}, {}, [](auto&, std::size_t) {}); }) {
    calls.add_impulses = [](void* l, contact_part p, std::span<const std::uint32_t> numbers,
                            plain_vector<vec3>& to) {
      list_at<List>(l).each_numbered(p, numbers, [&](const auto& row, std::size_t i) {
        if constexpr (requires { row.impulse(i); })
          to.push_back(row.impulse(i));
        else
          to.push_back(row[i].impulse());
      });
    };
    calls.add_strikes = [](void* l, contact_part p, std::span<const std::uint32_t> numbers,
                           plain_vector<char>& to) {
      list_at<List>(l).each_numbered(
          p, numbers, [&](const auto& row, std::size_t i) { to.push_back(strikes(row[i])); });
    };
  }
  calls.set = [](void* l, contact_part p, std::size_t i, const vec3& impulse) {
    list_at<List>(l).edit(p, i, [&](auto& c) { c.load_impulse(impulse); });
  };
  if constexpr (requires(List & list, state & s) { list.sweep_watched(s, real()); }) {
    calls.set_and_apply = [](void* l, std::size_t i, const vec3& impulse, state& s) {
      list_at<List>(l).edit(contact_part::interior, i, [&](auto& c) {
        const auto before = c.impulse_in_frame();
        c.load_impulse(impulse);
        c.apply(s, c.since(before));
      });
    };
    calls.set_at_boundary = [](void* l, std::size_t i, const vec3& impulse, state& s) {
      list_at<List>(l).set_at_boundary(i, impulse, s);
    };
    calls.sweep_watched = [](void* l, state& s,
                             real speed) -> const plain_vector<plain_pair<std::size_t, real>>& {
      return list_at<List>(l).sweep_watched(s, speed);
    };
    calls.largest_correction = [](void* l) {
      real most = 0;
      list_at<List>(l).each_interior_contact([&](const auto& c) {
        if (c.target_velocity == 0)
          most = std::max(most, std::abs(static_cast<real>(c.correction_rate)));
      });
      return most;
    };
  }
  return calls;
}();

/// All lists of contacts of a tuple.
template <class State, class Lists>
[[nodiscard]] plain_vector<contact_access<State>> access_to(Lists& lists) {
  plain_vector<contact_access<State>> all;
  each_of(lists, [&](auto& list) {
    if constexpr (!is_joint<typename std::remove_cvref_t<decltype(list)>::contact_type>)
      all.push_back(contact_access<State>(list));
  });
  return all;
}

}  // namespace talus::detail
