#pragma once
// What all functions of pairs of bodies begin with: contacts, soft forces, times of impact.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "talus/state/periodic_ghosts.hpp"
#include "talus/state/state.hpp"

namespace talus::detail {

/// Whether the owner of shadow copy `copy` has a copy of the body `own`, so that both ranks compute
/// their contact. (It has none in the one step after the user put a body at an unexpected place.)
template <class Own, class Other, class Scenario>
[[nodiscard]] bool copied_to_owner(const world_state<Scenario>& s, std::size_t own,
                                   std::size_t copy) {
  using shapes = typename world_state<Scenario>::finite_shapes;
  constexpr std::size_t other = index_of<shapes, Other>;
  std::size_t last = s.template of<Other>().movable.locals;
  for (const auto& n : s.neighbours) {
    last += n.copies[other];
    if (copy >= last) continue;
    std::uint32_t image = 0;
    if constexpr (world_state<Scenario>::periodic)
      image = periodic_box::reverse(copy_of<Other>(s, copy)->image);
    const auto& there = n.shadowed[index_of<shapes, Own>];
    return std::binary_search(there.begin(), there.end(),
                              world_state<Scenario>::copy_code::of(own, image));
  }
  return false;
}

/// Global surface j beside body i of shape A.
template <class A, class B, class Scenario>
[[nodiscard]] auto surface_near(world_state<Scenario>& s, std::size_t i, std::size_t j) {
  constexpr std::size_t a = index_of<typename world_state<Scenario>::finite_shapes, A>;
  auto& surfaces = s.template of<B>();
  if (surfaces.near.size() <= a) surfaces.near.resize(a + 1);
  return surfaces.global.shape[j].near(surfaces.near[a], i, j, surfaces.global.size());
}

/// The bodies of two shapes, the second ones movable or global. Base of what is done for each pair.
template <class Scenario, class ShapeA, class ShapeB, partner Partner>
class shape_pairs {
 protected:
  using state_type = world_state<Scenario>;
  using store_a = body_store<ShapeA, typename Scenario::features>;
  using store_b = body_store<ShapeB, typename Scenario::features>;
  static constexpr bool paired = Partner == partner::moving;
  static constexpr bool alike = paired && std::is_same_v<ShapeA, ShapeB>;
  static constexpr bool driven = !paired && state_type::drives;
  static constexpr bool imaged = paired && state_type::periodic;

  struct no_image {};
  /// Two bodies, by their indices; in periodic space the second one may be an image of a body that
  /// is owned here.
  struct body_pair {
    std::size_t i = 0, j = 0;
    bool own_a = false, own_b = false;  ///< an immovable partner counts as owned everywhere
    bool moves_a = false, moves_b = false;
    [[no_unique_address]] std::conditional_t<imaged, image_pair, no_image> at{};

    /// Whether it changes a body owned here.
    [[nodiscard]] bool acts_here() const { return (own_a && moves_a) || (own_b && moves_b); }
    /// Whether it changes bodies of two ranks, which both compute it.
    [[nodiscard]] bool crosses_ranks() const {
      return paired && own_a != own_b && moves_a && moves_b;
    }
  };

  explicit shape_pairs(state_type& s)
      : s_(s),
        a_(s.template of<ShapeA>().movable),
        b_(paired ? s.template of<ShapeB>().movable : s.template of<ShapeB>().global),
        first_a_(s.template of<ShapeA>().first),
        first_b_(paired ? s.template of<ShapeB>().first : 0) {}

  /// Bodies of one shape in the order of their ids, so that every rank that sees the pair computes
  /// the same. Returns whether they have changed places.
  [[gnu::always_inline]] bool order(std::size_t& i, std::size_t& j) const {
    if constexpr (alike)
      if (b_.id[j] < a_.id[i]) return std::swap(i, j), true;
    return (void)i, (void)j, false;
  }
  /// Completes the pair of x.i and x.j. Returns false if it is found through another image.
  [[nodiscard]] [[gnu::always_inline]] bool find(body_pair& x) const {
    x.own_a = x.i < a_.locals;
    x.own_b = !paired || x.j < b_.locals;
    if constexpr (imaged) {
      x.at = minimum_image<ShapeA, ShapeB>(s_, x.i, x.j);
      if (!x.at.known) return false;
      x.own_b = x.at.body_b < b_.locals;
    }
    x.moves_a = a_.moves(x.i), x.moves_b = paired && b_.moves(x.j);
    return true;
  }
  /// Whether both ranks compute a boundary pair.
  [[nodiscard]] bool known_to_both(const body_pair& x) const {
    if constexpr (paired)
      return x.own_a ? copied_to_owner<ShapeA, ShapeB>(s_, x.i, x.j)
                     : copied_to_owner<ShapeB, ShapeA>(s_, x.j, x.i);
    else
      return (void)x, true;
  }
  /// The second body itself, of which this may be an image of one that is owned here.
  [[nodiscard]] std::size_t body_b(const body_pair& x) const {
    if constexpr (imaged)
      return x.at.body_b;
    else
      return x.j;
  }
  /// Where the two bodies are, for this pair.
  [[nodiscard]] const vec3& position_a(const body_pair& x) const {
    if constexpr (imaged)
      return x.at.a;
    else
      return a_.position[x.i];
  }
  [[nodiscard]] const vec3& position_b(const body_pair& x) const {
    if constexpr (imaged)
      return x.at.b;
    else
      return b_.position[x.j];
  }
  [[nodiscard]] pose pose_a(const body_pair& x) const {
    return {position_a(x), a_.pose(x.i).orientation};
  }
  [[nodiscard]] pose pose_b(const body_pair& x) const {
    return {position_b(x), b_.pose(x.j).orientation};
  }

  /// The second shape of the pair (i, j); of a surface that part which is near the first body.
  [[nodiscard]] decltype(auto) shape_b(std::size_t i, std::size_t j) const {
    if constexpr (!paired && keeps_near<ShapeA, ShapeB>)
      return surface_near<ShapeA, ShapeB>(s_, i, j);
    else
      return std::as_const(b_.shape[j]);
  }

  state_type& s_;
  store_a& a_;
  store_b& b_;
  std::size_t first_a_, first_b_;  ///< of these bodies, in the arrays of the solver
};

}  // namespace talus::detail
