#pragma once
// Every role a policy can play, on one page. A type plays a role by what it offers, not by what it
// derives from; the law suite of the role (tests/laws/) says what the offers must mean.
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <ranges>
#include <string>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"

namespace talus {

namespace detail {

template <class Type>
concept complete = requires {
  sizeof(Type);
};

/// Stands for any callable argument in a requirement.
struct anything {
  template <class... Arguments>
  void operator()(Arguments&&...) const;
};

}  // namespace detail

namespace concepts {

/// A body's form: sphere, box, plane.
/// - `finite`: has a volume; `round`: isotropic inertia, every contact normal through the centre
/// - `name`: as scenarios spell it
/// - `validate()`: throws invalid_argument naming the value that is wrong
template <class Shape>
concept shape = requires(const Shape s) {
  { Shape::finite } -> std::convertible_to<bool>;
  { Shape::round } -> std::convertible_to<bool>;
  { Shape::name } -> std::convertible_to<std::string>;
  s.validate();
};

/// A shape with a volume, around its centre of mass.
/// - `bounding_radius()`; `volume()`
/// - `inertia()`: principal moments per unit of mass in the frame of the body
/// - `support(direction)`: the farthest point that way, all in the frame of the body
template <class Shape>
concept finite_shape = shape<Shape> && Shape::finite && requires(const Shape s, const vec3 v) {
  { s.bounding_radius() } -> std::convertible_to<real>;
  { s.volume() } -> std::convertible_to<real>;
  { s.inertia() } -> std::convertible_to<vec3>;
  { s.support(v) } -> std::convertible_to<vec3>;
};

/// A part of space: half-spaces and what intersect, merge and complement make of them.
/// - `value(p)`: positive inside, 0 on the boundary, negative outside; -value is at most the
///   distance of p from the region
template <class Region>
concept region = requires(const Region r, const vec3 p) {
  { r.value(p) } -> std::convertible_to<real>;
  { r.contains(p) } -> std::convertible_to<bool>;
};

/// A way to share out space among ranks, as the user writes it; by_hand leaves it to connect().
/// - `size()`: the number of ranks it wants, 0 if it fits any
/// - `resolve(ranks)`: fixes what is open, or throws invalid_argument with both numbers
template <class Decomposition>
concept decomposition = requires(const Decomposition d, const int ranks) {
  { d.size() } -> std::same_as<int>;
  d.resolve(ranks);
};

/// What a decomposition becomes once the number of ranks is known.
/// - `owner(p)`: total, unique, equal to the bit on all ranks
/// - `neighbours(rank, reach)`: the ranks within reach of a rank; `geometry(rank)`: its region
template <class Partition>
concept partition = requires(const Partition cells, const int rank, const real reach,
                             const vec3 p) {
  { cells.size() } -> std::same_as<int>;
  { cells.owner(p) } -> std::same_as<int>;
  { cells.neighbours(rank, reach) } -> std::same_as<std::vector<int>>;
  cells.geometry(rank);
};

/// One rank's end of the transport. Parcels are what neighbours send each other.
/// - `alone`: this kind of link never has a second rank
/// - `start(parcels)`, `finish(parcels)`: one exchange; the fixed form knows all sizes beforehand
/// - the rest is collective: for set-up and outputs only
template <class Link>
concept link = std::movable<Link> && requires(Link l, detail::byte_buffer bytes) {
  { Link::alone } -> std::convertible_to<bool>;
  { l.rank() } -> std::same_as<int>;
  { l.size() } -> std::same_as<int>;
  l.counters();
  l.barrier();
  { l.gather(bytes) } -> std::same_as<std::vector<detail::byte_buffer>>;
  { l.gather_all(bytes) } -> std::same_as<std::vector<detail::byte_buffer>>;
  l.broadcast(bytes);
};

/// How ranks talk: `launch(settings, main)` calls main(link&) on each of them.
template <class Transport>
concept transport = requires {
  typename Transport::link;
  { Transport::name } -> std::convertible_to<std::string>;
};

/// The part of broad_phase<...>: how pairs that may touch are found.
template <class Method>
concept broad_phase = detail::part_for<Method, roles::broad_phase>;

/// What holds at a contact.
/// - `friction`, `restitution`, `correction`: whether each is there
template <class Law>
concept contact_law = requires {
  { Law::friction } -> std::convertible_to<bool>;
  { Law::restitution } -> std::convertible_to<bool>;
  { Law::correction } -> std::convertible_to<bool>;
};

/// The part of solver<...>: how the impulses of all contacts are found.
template <class Method>
concept solver = detail::part_for<Method, roles::solver>;

/// The part of integrator<...>: how velocities and positions are stepped.
template <class Method>
concept integrator = detail::part_for<Method, roles::integrator>;

/// A toggle of features<...>.
template <class Feature>
concept feature = detail::part_for<Feature, roles::features>;

/// Sites to fill with bodies: lattices, rings, lists of points, and parts of them.
template <class Sites>
concept site_set = requires(const Sites s, const vec3 p) {
  s.for_each_in(p, p, detail::anything{});
};

}  // namespace concepts
}  // namespace talus
