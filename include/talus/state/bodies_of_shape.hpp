#pragma once
// All bodies of one shape known to a rank, and the search structures that find their neighbours.
#include <algorithm>
#include <limits>
#include <vector>

#include "talus/body/store.hpp"
#include "talus/concepts.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/type_list.hpp"
#include "talus/detect/box_batch.hpp"
#include "talus/detect/collide_pair.hpp"
#include "talus/detect/ellipsoid_batch.hpp"
#include "talus/detect/hash_grid.hpp"
#include "talus/detect/sphere_batch.hpp"
#include "talus/shape/sphere.hpp"

namespace talus::detail {

/// Extra distance within which pairs become contacts, as a part of the bounding radius: contacts
/// that are about to close keep their impulse and their place.
inline constexpr real contact_slack = 0.01;

/// What detection reads of the bodies of a shape, computed once per step.
template <class Shape>
struct places_of {};
template <computed_in_batches Shape>
struct places_of<Shape> {
  plain_vector<typename batch_of<Shape>::type::place> places;
};
template <>
struct places_of<sphere> {
  plain_vector<moving_sphere> places;
  plain_vector<placed_sphere> resting;  ///< for contacts that are kept
};

/// Whether B is a surface that keeps its parts near bodies of shape A.
template <class A, class B>
concept keeps_near = requires {
  requires collides_in_order<typename B::near_lists::view, A>;
};
/// The parts of a surface that are near the bodies of each shape; empty for other shapes.
template <class Shape>
struct parts_near {};
template <class Shape>
requires requires { typename Shape::near_lists; }
struct parts_near<Shape> {
  std::vector<typename Shape::near_lists> near;
};

template <class Shape, class Features, class Search>
struct bodies_of_shape : places_of<Shape>, parts_near<Shape> {
  using shape_type = Shape;
  using store_type = body_store<Shape, Features>;
  static_assert(concepts::pair_search<Search>,
                "this broad phase cannot be used: its `search` needs build, size, bytes, pairs, "
                "pairs_with and query, as concepts::pair_search says");

  store_type movable;     ///< locals and shadow copies (a finite shape only)
  store_type global;      ///< known on every rank, immovable
  std::size_t first = 0;  ///< index of this shape's first body in the solver's arrays

  Search grid;  ///< of the movable bodies, rebuilt each step
  plain_vector<real> reach;
  Search global_grid;  ///< of the global bodies, rebuilt when they change
  plain_vector<real> global_reach;
  bool globals_changed = false;
};

/// Bounding radius plus slack plus the distance that the surface can move in `dt`.
template <class Store>
[[nodiscard]] real reach_of(const Store& s, std::size_t i, real dt) {
  const real radius = s.shape[i].bounding_radius();
  real speed = s.velocity[i].norm();
  if constexpr (Store::tensor) speed += radius * s.angular_velocity[i].norm();
  return (1 + contact_slack) * radius + speed * dt;
}
/// How far the rotation of a body can move a point of its surface.
template <class Store>
[[nodiscard]] real way_of_turning(const Store& s, std::size_t i, real dt) {
  if constexpr (Store::tensor)
    return s.angular_velocity[i].norm() * s.shape[i].bounding_radius() * dt;
  return (void)s, (void)i, (void)dt, 0;
}

}  // namespace talus::detail
