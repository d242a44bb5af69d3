#pragma once
// Every role of a policy, on one page. A type plays a role by its members, not by its base class;
// the law suite of the role (tests/*/*_laws.hpp) defines the meaning of the members.
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "talus/core/bytes.hpp"
#include "talus/core/math.hpp"
#include "talus/core/policy.hpp"

namespace talus {

// Arguments of links and transports; see parallel/.
struct neighbour_message;
struct traffic;
struct launch_settings;
enum class reduction;
// Arguments and results of interaction laws; see interaction/contact_kinematics.hpp.
template <class Number>
struct contact_kinematics_of;
using contact_kinematics = contact_kinematics_of<double>;
template <class Number>
struct interaction_force_of;
using interaction_force = interaction_force_of<double>;
template <class Number>
struct stored_energy_of;
using stored_energy = stored_energy_of<double>;
template <class Number>
struct bearing_of;
using bearing = bearing_of<double>;
struct head_on_impact;

// Arguments of solvers; see solver/.
struct solver_settings;
namespace detail {

template <class Real>
struct solver_state_of;
class line_writer;
struct solved;
struct contact_key;
enum class history_place : std::uint32_t;

/// Whether a type is defined here, or only declared. (A constant instead of a concept, because the
/// diagnostics of compilers are shorter if it is false.)
template <class Type>
inline constexpr bool complete = requires {
  sizeof(Type);
};

/// Stands for any callable argument in a requirement.
struct anything {
  template <class... Arguments>
  void operator()(Arguments&&...) const;
};

/// Receives a region part by part: groups open and close, and contain half-spaces.
struct any_sink {
  void open(bool all_of);
  template <class HalfSpace>
  void plane(const HalfSpace&);
  void close();
};

/// Stands for the ghost exchange of a world that has one rank.
struct any_ghost_exchange {
  static constexpr bool alone = true, coloured = true;
  [[nodiscard]] std::uint32_t colours() const;
};

}  // namespace detail

namespace concepts {

/// A body's form: sphere, box, plane. Data with functions in its own frame, whose origin is the
/// centre of mass and whose axes are the principal axes of inertia. Plain data, or a type that
/// defines its own serialization (`packs_itself` of core/bytes.hpp) and shares large data
/// (core/shared_data.hpp).
/// - `finite`: has a volume, and so a mass
/// - `isotropic`: isotropic inertia, and every contact normal goes through the centre: the
///   orientation has no effect
/// - `name`: its name in messages
/// - `validate()`: throws invalid_argument that names the wrong value
template <class Shape>
concept shape = requires(const Shape& s) {
  { Shape::finite } -> std::convertible_to<bool>;
  { Shape::isotropic } -> std::convertible_to<bool>;
  { Shape::name } -> std::convertible_to<const char*>;
  { s.validate() } -> std::same_as<void>;
}
&&std::semiregular<Shape>;

/// A shape with a volume.
/// - `bounding_radius()`: of the smallest ball about the centre of mass; `volume()`
/// - `inertia()`: principal moments per unit of mass (length squared)
/// - `support(direction)`: a point furthest along a direction of any length
/// - `half_extents(pose)`: half edges of the axis-aligned box around the posed shape, with the
///   centre of mass in its middle
/// and optionally
/// - `frame()`: the frame of the body in the coordinates in which the shape was given; without it
///   the two are the same (see shape/frame.hpp)
/// - `reach_from(point)`: distance of the furthest point; bounds unions, whose bounds are larger
///   without it
template <class Shape>
concept finite_shape = shape<Shape> && Shape::finite &&
    requires(const Shape& s, const vec3& v, const pose& p) {
  { s.bounding_radius() } -> std::convertible_to<real>;
  { s.volume() } -> std::convertible_to<real>;
  { s.inertia() } -> std::convertible_to<vec3>;
  { s.support(v) } -> std::convertible_to<vec3>;
  { s.half_extents(p) } -> std::convertible_to<vec3>;
};

/// A convex shape: its support function is enough for contacts with all other shapes, and for its
/// picture. (Not a union of parts, and not a surface of triangles, which have routines of their
/// own.) Optional members make it faster, or better:
/// - `form()`: its flat faces and straight edges, one of the forms of shape/convex_form.hpp
/// - `inner_radius()`: of a ball about the centre of mass inside the shape; without it, its bounds
///   are computed for each pair
/// - `smallest_curvature_radius()`: overlaps of smooth shapes up to it have one normal only, which
///   is found without a search for others
/// - `largest_curvature_radius()`: with the smallest one, the velocities at a contact decide
/// whether
///   such shapes meet in a step; both must then bound the radii of curvature of the whole surface
/// - `level(p)`: the surface as the level of a convex function (shape/surface_level.hpp), for exact
///   points where a smooth shape is flat
/// - `flat_sides`: false if no side is flat and no line of the surface is straight; without it such
///   sides are looked for, unless there are `form()`, `bend()` or `level()`
/// - `numbers`: the names of its numbers, in the order of its members, for checkpoints and Python
/// - `homogeneous`: false if its mass does not fill it evenly, as that of a hollow body
/// A shape of a user's own is tested when bodies with it are added: its support function must be
/// that of a convex body with the centre of mass inside, and within the bounds, and volume and
/// inertia must be about those of that body, and form() must reach as far
/// (shape/support_check.hpp).
template <class Shape>
concept convex_shape = finite_shape<Shape> && !requires(const Shape& s) {
  s.parts();
}
&&!requires(const Shape& s) { s.tree(); };

/// A part of space, as a value.
/// - `value(p)`: positive inside, 0 on the boundary, negative outside, and at most the distance of
///   p from the boundary: -value is a lower bound of the distance from the region
/// - `contains(p)`: value(p) >= 0; regions are closed
template <class Region>
concept region = requires(const Region& r, const vec3& p) {
  { r.value(p) } -> std::convertible_to<real>;
  { r.contains(p) } -> std::same_as<bool>;
};

/// A region bounded by planes: half-spaces and their intersections, unions and complements.
/// - `owns(p)`: contains(p), except that each point of the boundary belongs to exactly one of a
///   region and its complement, the side towards +x (if that is undecided +y, then +z): regions
///   that tile space assign every point exactly once
/// - `describe(sink)`: its parts
template <class Region>
concept polyhedral = region<Region> &&
    requires(const Region& r, const vec3& p, detail::any_sink& sink) {
  { r.owns(p) } -> std::same_as<bool>;
  r.describe(sink);
};

/// A partition of space among ranks, as the user writes it: a plain value. by_hand, which leaves
/// all connections to connect(), is the decomposition without a partition.
/// - `size()`: the number of ranks it needs, 0 if it fits any
/// - `resolve(ranks)`: sets open values; throws invalid_argument with both numbers if they do not
///   match
template <class Decomposition>
concept decomposition = requires(const Decomposition& d, int ranks) {
  { d.size() } -> std::same_as<int>;
  d.resolve(ranks);
}
&&std::copyable<Decomposition>;

/// A decomposition after the number of ranks is known.
/// - `owner(p)`: total (every point has exactly one owner, by one transitive rule; only NaN has no
///   owner: -1), and equal to the bit on all ranks
/// - `neighbours(rank, reach)`: in ascending order, without `rank`, all ranks whose region comes
///   within reach (a length) of that of `rank`; more ranks are allowed, but cost messages
/// - `geometry(rank)`: its closed region, which differs from owner() by round-off only
/// - `bounds(rank)`, optional: an axis-aligned box around that (lower, upper corner)
template <class Partition>
concept partition = std::copyable<Partition> &&
    requires(const Partition& cells, int rank, real reach, const vec3& p) {
  { cells.size() } -> std::same_as<int>;
  { cells.owner(p) } -> std::same_as<int>;
  { cells.neighbours(rank, reach) } -> std::same_as<std::vector<int>>;
  { cells.geometry(rank) } -> polyhedral;
};

/// A partition some of whose faces are closed: bodies never cross them, so ranks that touch only
/// there are not connected, and a body that reaches such a face ends the run.
/// - `closed(rank)`: those ranks in ascending order; symmetric, and disjoint from neighbours(rank,
///   0)
template <class Partition>
concept closing_partition = partition<Partition> && requires(const Partition& cells, int rank) {
  { cells.closed(rank) } -> std::same_as<std::vector<int>>;
};

/// A partition of a periodic box.
/// - `box()`: its images; owner() is that of the image in the box, geometry() lies in it
/// - `neighbours(rank, reach)` counts images of regions, those of `rank` itself included
template <class Partition>
concept periodic_partition = partition<Partition> && requires(const Partition& cells) {
  cells.box().wrapped(vec3{});
};

/// A decomposition that determines the owner of every point and generates all connections.
template <class Decomposition>
concept generating_decomposition = decomposition<Decomposition> &&
    requires(const Decomposition& d) {
  { d.resolve(1) } -> partition;
};

/// A generating decomposition whose cuts can move during the run: features<balancing>.
/// - `shared_out(link, places, weight, ranks)`: the same with cuts that give each rank an equal
///   share of a load. Collective; equal on all ranks. Each rank passes the places of its bodies,
///   and the weight of one of them
/// - `positions()`: the positions of the cuts, as numbers; `placed(positions)`: the same with cuts
///   there
template <class Decomposition>
concept movable_decomposition = generating_decomposition<Decomposition> &&
    requires(const Decomposition& d, detail::anything& link, std::span<const vec3> places,
             std::uint64_t weight, int ranks, std::span<const real> positions) {
  { d.shared_out(link, places, weight, ranks) } -> std::same_as<Decomposition>;
  { d.positions() } -> std::same_as<std::vector<real>>;
  { d.placed(positions) } -> std::same_as<Decomposition>;
};

/// One rank's end of all its connections. Used by one thread at a time.
/// - `alone`: there is never a second rank
/// - `start(parcels)` posts one message per parcel and returns at once, `finish(parcels)` waits for
///   one per parcel. Both sides of a pair list each other, and their exchanges match in the order
///   in which they are made; ranks may otherwise drift apart. One exchange is open at a time
/// - `start_fixed`, `finish_fixed`: the same if each parcel's `in` already has the size of the
///   incoming message (else runtime_error), for the iterations of a solver
/// - `start_reduce(how, values)` contributes this rank's values and returns at once,
///   `finish_reduce(values)` waits for those of all ranks and combines them, as reduce() does. The
///   values stay unchanged in between, when exchanges are allowed; one such reduction is open at a
///   time
/// - the rest is collective, for set-up and outputs only: every rank calls the same functions in
///   the same order. `gather` has its result on rank 0 alone, `broadcast` sends from there
/// - `counters()`: the traffic that this rank has sent so far
template <class Link>
concept link = std::movable<Link> &&
    requires(Link l, const Link& c, std::span<neighbour_message> neighbour_messages,
             detail::byte_buffer& bytes, reduction how, std::span<double> reals,
             std::span<std::uint64_t> counts) {
  { Link::alone } -> std::convertible_to<bool>;
  { c.rank() } -> std::same_as<int>;
  { c.size() } -> std::same_as<int>;
  { c.counters() } -> std::same_as<const traffic&>;
  l.start(neighbour_messages);
  l.finish(neighbour_messages);
  l.start_fixed(neighbour_messages);
  l.finish_fixed(neighbour_messages);
  l.barrier();
  { l.gather(bytes) } -> std::same_as<std::vector<detail::byte_buffer>>;
  { l.gather_all(bytes) } -> std::same_as<std::vector<detail::byte_buffer>>;
  l.broadcast(bytes);
  l.reduce(how, reals);
  l.reduce(how, counts);
  l.start_reduce(how, reals);
  l.finish_reduce(reals);
};

/// The communication of ranks: starts ranks and runs main(link&) on each. An exception on any rank
/// ends all of them: one error reaches the caller (ranks inside the process) or the user
/// (processes).
template <class Transport>
concept transport = link<typename Transport::link> && requires(const launch_settings& settings) {
  { Transport::name } -> std::convertible_to<const char*>;
  Transport::launch(settings, detail::anything{});
};

/// A broad phase finds pairs of balls that touch, each once, in an order that depends on the input
/// alone.
/// - `build`: takes the centres and the reaches of all balls; throws unplaceable for one that is
///   not finite
/// - `pairs(f)`: f(i, j) for each unordered pair; `pairs_with(other, f)`: f(i, j of other)
/// - `query(centre, reach, f)`: f(i) for each ball that touches this one
template <class Search>
concept pair_search = std::default_initializable<Search> &&
    requires(Search s, const Search& c, std::span<const vec3> centres,
             std::span<const real> reaches, const vec3& centre, detail::anything f) {
  s.build(centres, reaches);
  { c.size() } -> std::convertible_to<std::size_t>;
  { c.bytes() } -> std::convertible_to<std::size_t>;
  c.pairs(f);
  c.pairs_with(c, f);
  c.query(centre, real{}, f);
};

/// The part of broad_phase<...>: how candidate pairs are found. Its `search` is a pair_search.
template <class Method>
concept broad_phase = detail::part_for<Method, roles::broad_phase> && requires {
  typename Method::search;
};

/// The law that holds at a contact.
/// - `soft`: bodies overlap and springs push them apart; otherwise impulses keep them apart
/// - `friction`, `restitution`, `correction`: whether each is present
/// - `memory`: the state that a contact keeps from step to step, found by its key
template <class Law>
concept contact_law = requires {
  typename Law::memory;
  { Law::soft } -> std::convertible_to<bool>;
  { Law::friction } -> std::convertible_to<bool>;
  { Law::restitution } -> std::convertible_to<bool>;
  { Law::correction } -> std::convertible_to<bool>;
};

/// The stored data of a part of soft_contact<...>: its parameters for each pair of materials, and
/// its memory for each contact, which migrates with the bodies and is written to checkpoints.
template <class Part>
concept contact_data = detail::part_for<Part, roles::contact_law> && requires {
  typename Part::parameters;
  typename Part::memory;
  { Part::name } -> std::convertible_to<const char*>;
} && std::is_trivially_copyable_v<typename Part::parameters> &&
    std::default_initializable<typename Part::parameters> &&
    std::equality_comparable<typename Part::parameters> &&
    std::is_trivially_copyable_v<typename Part::memory> &&
    std::default_initializable<typename Part::memory> && std::is_class_v<typename Part::memory> &&
    !std::is_final_v<typename Part::memory>;

/// A force between two bodies at a point where they touch or nearly touch; a part of
/// soft_contact<...>. All functions are static, and depend on their arguments alone.
/// - `name`: its name in messages and checkpoints
/// - `parameters`: of a pair of materials; trivially copyable, with ==
/// - `memory`: of a contact from step to step; a trivially copyable class, empty if the law has no
///   memory
/// - `force(c, p, dt, memory)`: force and moment on body a, and the part of them that comes from
///   the stored energy; advances the memory by dt
/// - `stored(c, p, memory)`: the energy that the contact can return
/// - `longest_step(p, mass)`: the longest stable time step of two bodies of this mass, or infinity;
///   optionally `longest_step(p, mass, stiffer)` of bodies that several contacts make stiffer by
///   this factor, without it that of a mass smaller by the factor
/// - `duration(p, impact)`: the duration of an impact, or infinity and, optionally,
/// - `range(p, radius)`: the gap up to which it acts, for the effective radius of the two bodies,
///   not decreasing with it; without it the law acts where bodies overlap
/// - `combine(material, material, pair_material)`: the parameters of a pair for which the user set
///   none; without it world.interaction(...) sets them
/// - `given` and `combine(a, b, both, g)`: the type that world.interaction takes in place of the
///   parameters, and the parameters from it and two materials
/// - `require_parameters(p)`: throws invalid_argument for parameters without meaning
/// - `require_material(material)`: throws invalid_argument for a material that it cannot use;
///   `rigid_by(material)`: the field that makes bodies of it rigid, or null
/// - `longest_step_of_body(material, radius)`: the same of each body, for any partner
/// - `central`: true if the force is along the normal and the moment is zero, which costs less
/// - `each_column(memory, f)`, of its memory: f(name, member) for the columns of a checkpoint;
///   without it the memory is stored as bytes
template <class Law>
concept interaction_law = contact_data<Law> &&
    requires(const contact_kinematics& c, const typename Law::parameters& p, real x,
             typename Law::memory& memory, const typename Law::memory& kept,
             const head_on_impact& impact) {
  { Law::force(c, p, x, memory) } -> std::derived_from<interaction_force>;
  { Law::stored(c, p, kept) } -> std::same_as<stored_energy>;
  { Law::longest_step(p, x) } -> std::convertible_to<real>;
  { Law::duration(p, impact) } -> std::convertible_to<real>;
};

/// An interaction law whose normal force bounds friction and rolling resistance.
/// - `bears(c, p)`: its stiffnesses, a `bearing`
/// - `force` also returns a bearing, with the normal force
template <class Law>
concept bearing_law = interaction_law<Law> &&
    requires(const contact_kinematics& c, const typename Law::parameters& p, real x,
             typename Law::memory& memory) {
  { Law::bears(c, p) } -> std::derived_from<bearing>;
  { Law::force(c, p, x, memory) } -> std::derived_from<bearing>;
};

/// A force or moment bounded by the normal force of a law: rolling_resistance, and coulomb_friction
/// by tangential_spring.
/// - `force(c, bearing, p, dt, memory)`, `stored(c, bearing, p, memory)`: as for a law; the energy
///   is held in the memory
template <class Part>
concept resistance = contact_data<Part> &&
    requires(const contact_kinematics& c, const bearing& b, const typename Part::parameters& p,
             real x, typename Part::memory& memory, const typename Part::memory& kept) {
  { Part::force(c, b, p, x, memory) } -> std::derived_from<interaction_force>;
  { Part::stored(c, b, p, kept) } -> std::convertible_to<real>;
};

/// A constraint that joins two bodies, or a body and something immovable, by impulses: a contact, a
/// joint. Plain bytes. Impulses act on body `a` and, opposite, on body `b`; velocities are those of
/// a relative to b.
/// - `a`, `b`: the bodies, as indices of the solver's arrays; `paired`: whether b can move
/// - `rows`: of the Delassus operator
/// - `prepare(s, split_a, split_b)`: computes the effective masses, with the masses of a and b
///   divided into so many parts
/// - `relax(s)`: solves this constraint alone for the velocities of `s`; returns the `change` of
///   its impulse, in a frame of its own. The change is not applied
/// - `apply(s, change)`, `apply_to_a(s, change)`: applies a change to both bodies, to a
/// - `impulse_in_frame()`, `set(change)`, `since(change)`: the impulse in that frame; sets a new
///   one; the difference to an earlier one
/// - `relax_correction(s)`, `correct_a(s, x)`, `correct_b(s, x)`: the same for the
///   pseudo-velocities of the position correction
/// - `relative_velocity(s)`, `delassus_trace(s)`: the velocity of its rows, and the sum of the
///   diagonal of its effective inverse mass, with undivided masses; terms of the residual
/// - `speed_of(change)`: the change of velocity at the constraint that a change of impulse causes
template <class Kind>
concept constraint_kind = std::is_trivially_copyable_v<Kind> &&
    requires(Kind c, const Kind& k, typename Kind::state& s, const typename Kind::state& seen,
             const typename Kind::change& d) {
  { Kind::paired } -> std::convertible_to<bool>;
  { Kind::rows } -> std::convertible_to<int>;
  { k.a } -> std::convertible_to<std::int32_t>;
  { k.b } -> std::convertible_to<std::int32_t>;
  c.prepare(seen, 1, 1);
  { c.relax(seen) } -> std::same_as<typename Kind::change>;
  k.apply(s, d);
  k.apply_to_a(s, d);
  { k.impulse_in_frame() } -> std::convertible_to<typename Kind::change>;
  c.set(d);
  { k.since(d) } -> std::same_as<typename Kind::change>;
  k.correct_a(s, c.relax_correction(s));
  k.correct_b(s, c.relax_correction(s));
  k.relative_velocity(seen);
  { k.delassus_trace(seen) } -> std::convertible_to<real>;
  { k.speed_of(d) } -> std::convertible_to<real>;
};

/// A constraint that bounds impulses by a cone: a contact.
/// - `load_impulse(p)`, `impulse()`: the impulse on a in the world, for warm starts. A loaded
///   impulse is projected into the set of admissible impulses
/// - `axis()`, `mu()`, `target_velocity`: further terms of the residual; `axes()`, `lever_a()`,
///   `lever_b()`: its frame and arms
template <class Kind>
concept contact_kind = constraint_kind<Kind> &&
    requires(Kind c, const Kind& k, const typename Kind::state& seen, const vec3& p) {
  c.load_impulse(p);
  { k.impulse() } -> std::convertible_to<vec3>;
  { k.relative_velocity(seen) } -> std::convertible_to<vec3>;
  { k.axis() } -> std::convertible_to<vec3>;
  { k.mu() } -> std::convertible_to<real>;
  { k.target_velocity } -> std::convertible_to<real>;
  { k.axes() } -> std::convertible_to<mat3>;
  { k.lever_a() } -> std::convertible_to<vec3>;
  { k.lever_b() } -> std::convertible_to<vec3>;
};

/// A kind of joint, a part of joints<...>: a value type that the user fills in, in the coordinates
/// of the world. Its conditions are linear or bilinear in points and axes that the bodies carry
/// (constraint/joint_geometry.hpp).
/// - `name`: its name in messages and checkpoints; `rows`: the number of its rows
/// - `validate()`: throws invalid_argument that names the wrong value
/// - `anchors`: the joint as its bodies carry it; made of reals, with a member `frames`
///   (detail::joint_frames). It travels with the bodies, and is written to checkpoints
/// - `fix(a, b)`: the anchors for bodies with these poses
/// - `write(anchors, writer)`, static: writes its rows, always in the same slots, by a
///   detail::line_writer: conditions by `hold`, free coordinates by `turn`, `travel`
///   and `stretch`
/// and optionally
/// - `room(anchors)`, static: how far its two points may part; `roams`: whether there is no limit
/// - `has_angle`, `has_travel`: its coordinates, an angle first; `drive(anchors, motor)`, static:
///   changes its motor
template <class Kind>
concept joint_kind = detail::part_for<Kind, roles::joints> && std::is_trivially_copyable_v<Kind> &&
    requires(const Kind& k, const pose& p, const typename Kind::anchors& x,
             detail::line_writer& to) {
  { Kind::name } -> std::convertible_to<const char*>;
  { Kind::rows } -> std::convertible_to<int>;
  { k.validate() } -> std::same_as<void>;
  { k.fix(p, p) } -> std::same_as<typename Kind::anchors>;
  x.frames;
  Kind::write(x, to);
} && std::is_trivially_copyable_v<typename Kind::anchors>;

/// The constraints of one kind on a rank, as a solver stores them.
/// - `add(constraint, key, a_moves, b_moves, place, at_border)`: one that this rank solves by
///   itself
/// - `add_boundary(constraint, key, owns_a, place)`: one between a body owned here and a ghost
/// - `each(f)`: f(constraint, counts_here); over all ranks each counts once. `each_acting(f)`:
///   f(constraint, acts_on_a, acts_on_b); over all ranks each acts once on each of its bodies
/// - `load_impulses(history)`, `store_impulses(history)`: from the last step, and for the next
/// - `counted()`: the number of those that count here
template <class List>
concept constraint_list = std::default_initializable<List> &&
    requires(List l, const List& c, const typename List::contact_type& one,
             const detail::contact_key& key, detail::history_place* place, detail::anything f) {
  requires constraint_kind<typename List::contact_type>;
  l.clear();
  l.add(one, key, true, true, place, false);
  l.add_boundary(one, key, true, place);
  { c.size() } -> std::same_as<std::size_t>;
  { c.counted() } -> std::same_as<std::size_t>;
  { c.bytes() } -> std::same_as<std::size_t>;
  c.each(f);
  c.each_acting(f);
};

/// How the velocities of bodies reach their ghosts on other ranks during a solve.
/// - `alone`: there is one rank, and nothing to exchange
/// - `share_velocities()`: refreshes all ghosts; in two halves `start_velocities()` and
///   `finish_velocities()`, between which own velocities that are sent must not change
/// - `start_corrections()`, `finish_corrections()`: the same for the pseudo-velocities of the
///   position correction
/// - `start_reduce(sums)`, `finish_reduce(sums)`: sums over all ranks
template <class Exchange>
concept ghost_exchange = requires(Exchange e, std::span<double> sums) {
  { Exchange::alone } -> std::convertible_to<bool>;
  e.share_velocities();
  e.start_velocities();
  e.finish_velocities();
  e.start_corrections();
  e.finish_corrections();
  e.start_reduce(sums);
  e.finish_reduce(sums);
};

/// The part of solver<...>: how the impulses of all constraints are computed.
/// - `solve(lists, state, settings, correct, ranks)`, static: changes the velocities in `state` and
///   the impulses in `lists` (a tuple of constraint lists), and returns the iterations and the
///   residual. Impulses end in their admissible sets, and each acts on its two bodies with opposite
///   sign; over ranks it refreshes ghosts by `ranks`, and reduces over all ranks only if a
///   tolerance is set
/// - `uses_substeps`, optional: if true, positions also follow solver_state::drift
/// - `solves_joints`, optional: it solves joints all at once, by detail::exact_joints; for others
///   that is done after solve(), unless they use substeps
/// - `by_colours`, optional: if true, it sweeps colour by colour, in an order that depends on the
///   ids of bodies
template <class Method>
concept solver = detail::part_for<Method, roles::solver> &&
    requires(std::tuple<>& lists, detail::solver_state_of<double>& s,
             const solver_settings& settings, detail::any_ghost_exchange& ranks) {
  { Method::name } -> std::convertible_to<const char*>;
  { Method::solve(lists, s, settings, true, ranks) } -> std::same_as<detail::solved>;
};

/// The part of integrator<...>: how velocities and positions are advanced.
/// - `step(state)`, static: the stages of a time step in their order, with the hooks of the
///   features at each (state/hooks.hpp)
/// - `state<Scenario>`: its data on a rank; its members are those of the world's state
/// - `at_midpoint`: whether contacts are found and solved in the middle of a step; `shares_midway`:
///   whether bodies migrate, and shadow copies are refreshed, before forces are computed
template <class Method>
concept integrator = detail::part_for<Method, roles::integrator> && requires {
  { Method::name } -> std::convertible_to<const char*>;
  { Method::at_midpoint } -> std::convertible_to<bool>;
  { Method::shares_midway } -> std::convertible_to<bool>;
};

/// The part of precision<...>: double, or a type that names scalars.
/// - `solved`: the scalar of velocities, and of contacts of isotropic bodies, while contacts are
///   solved
template <class Numbers>
concept precision = std::same_as<Numbers, double> ||
    (detail::part_for<Numbers, roles::precision>&& requires { typename Numbers::solved; });

/// A quantity that bodies carry. One description drives storage, messages, checkpoints, output and
/// digests (body/column.hpp).
/// - `value_type`: plain bytes; `name`: of the dataset in checkpoints and outputs, and optionally
/// - `unit`: as in "K"; `initial`: the value of a new body
/// - `travel`: when it is sent to other ranks (talus::travels), by default with every refresh
/// - `in_checkpoint`, `in_output`, `in_digest`: whether files and state_digest() contain it, by
///   default true
/// - `carried_by<Shape>`: which bodies have it, by default all
template <class Column>
concept column = std::semiregular<typename Column::value_type> && requires {
  { Column::name } -> std::convertible_to<const char*>;
};

/// A part of features<...>: a module with one or more of
/// - `columns`: its columns of the bodies, a type_list of concepts::column
/// - `state`: its data on each rank, a struct with default values, or a template with the scenario
///   as argument; the optional `each_number(visit)` of it names the numbers in checkpoints
///   (state/monitor_numbers.hpp)
/// - `hooks`: a struct of static functions named after the stages of a step (body/stages.hpp),
///   which take a stage_view (world/stage_view.hpp)
/// and optionally
/// - `runs_after`: a type_list of the features that act before it at each stage
/// - `checkpoints_may_differ`: true if a run without it may continue from a checkpoint of one with
///   it
template <class Feature>
concept feature = detail::part_for<Feature, roles::features> && requires {
  { Feature::name } -> std::convertible_to<const char*>;
} &&(
    requires { typename Feature::columns; } || requires { typename Feature::state; } ||
    requires { typename Feature::template state<void>; } || requires { typename Feature::hooks; });

/// Sites to fill with bodies: lattices, rings, lists of points, and parts of them.
template <class Sites>
concept site_set = requires(const Sites s, const vec3 p) {
  s.for_each_in(p, p, detail::anything{});
};

}  // namespace concepts
}  // namespace talus
