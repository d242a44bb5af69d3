#pragma once
// The fields of options, as messages list them. Written by ./dev docs --sheet from the structs.
#include "talus/core/refused_fields.hpp"

namespace talus::detail::fields {

// clang-format off
inline constexpr sentence material = "world.material({...}) takes the fields density, restitution, friction, dynamic_friction, stiffness, youngs_modulus, poisson_ratio, rolling_friction, name and colour, in this order";
template <sentence S> struct no_material {
  static_assert(unrefused<S>, "world.material({...}) takes the fields density, restitution, friction, dynamic_friction, stiffness, youngs_modulus, poisson_ratio, rolling_friction, name and colour, in this order");
};
struct material_fields {
  static constexpr auto says = material;
  template <sentence S> using refused = no_material<S>;
};
inline constexpr sentence pair_material = "world.material_pair(a, b, {...}) takes the fields restitution, friction, dynamic_friction and cohesion, in this order";
template <sentence S> struct no_pair_material {
  static_assert(unrefused<S>, "world.material_pair(a, b, {...}) takes the fields restitution, friction, dynamic_friction and cohesion, in this order");
};
struct pair_material_fields {
  static constexpr auto says = pair_material;
  template <sentence S> using refused = no_pair_material<S>;
};
inline constexpr sentence pair_rules = "world.pair_rules({...}) takes the fields restitution and friction, in this order";
template <sentence S> struct no_pair_rules {
  static_assert(unrefused<S>, "world.pair_rules({...}) takes the fields restitution and friction, in this order");
};
struct pair_rules_fields {
  static constexpr auto says = pair_rules;
  template <sentence S> using refused = no_pair_rules<S>;
};
inline constexpr sentence simulation = "world.simulate({...}) takes the fields steps, dt, stop_when and check_every, in this order";
template <sentence S> struct no_simulation {
  static_assert(unrefused<S>, "world.simulate({...}) takes the fields steps, dt, stop_when and check_every, in this order");
};
struct simulation_fields {
  static constexpr auto says = simulation;
  template <sentence S> using refused = no_simulation<S>;
};
inline constexpr sentence unit_names = "world.units({...}) takes the fields length, mass and time, in this order";
template <sentence S> struct no_unit_names {
  static_assert(unrefused<S>, "world.units({...}) takes the fields length, mass and time, in this order");
};
struct unit_names_fields {
  static constexpr auto says = unit_names;
  template <sentence S> using refused = no_unit_names<S>;
};
inline constexpr sentence balance_settings = "world.balance({...}) takes the fields every, above and by, in this order";
template <sentence S> struct no_balance_settings {
  static_assert(unrefused<S>, "world.balance({...}) takes the fields every, above and by, in this order");
};
struct balance_settings_fields {
  static constexpr auto says = balance_settings;
  template <sentence S> using refused = no_balance_settings<S>;
};
inline constexpr sentence sleep_settings = "world.sleeping({...}) takes the fields speed and time, in this order";
template <sentence S> struct no_sleep_settings {
  static_assert(unrefused<S>, "world.sleeping({...}) takes the fields speed and time, in this order");
};
struct sleep_settings_fields {
  static constexpr auto says = sleep_settings;
  template <sentence S> using refused = no_sleep_settings<S>;
};
inline constexpr sentence servo = "world.hold_force(body, {...}) takes the fields force, pressure, max_speed and axis, in this order";
template <sentence S> struct no_servo {
  static_assert(unrefused<S>, "world.hold_force(body, {...}) takes the fields force, pressure, max_speed and axis, in this order");
};
struct servo_fields {
  static constexpr auto says = servo;
  template <sentence S> using refused = no_servo<S>;
};
inline constexpr sentence inflow = "insert_by_rate(world, {...}, region, make) takes the fields bodies, mass, from, most, tries and name, in this order";
template <sentence S> struct no_inflow {
  static_assert(unrefused<S>, "insert_by_rate(world, {...}, region, make) takes the fields bodies, mass, from, most, tries and name, in this order");
};
struct inflow_fields {
  static constexpr auto says = inflow;
  template <sentence S> using refused = no_inflow<S>;
};
inline constexpr sentence picture = "take_pictures(world, options, {...}) takes the fields from, at, up, angle, colour, fastest, walls, copies, domains, ground, joints, force and follow, in this order";
template <sentence S> struct no_picture {
  static_assert(unrefused<S>, "take_pictures(world, options, {...}) takes the fields from, at, up, angle, colour, fastest, walls, copies, domains, ground, joints, force and follow, in this order");
};
struct picture_fields {
  static constexpr auto says = picture;
  template <sentence S> using refused = no_picture<S>;
};
inline constexpr sentence field_grid = "measure_fields(world, {...}) takes the fields lower, upper and cells, in this order";
template <sentence S> struct no_field_grid {
  static_assert(unrefused<S>, "measure_fields(world, {...}) takes the fields lower, upper and cells, in this order");
};
struct field_grid_fields {
  static constexpr auto says = field_grid;
  template <sentence S> using refused = no_field_grid<S>;
};
inline constexpr sentence grid = "world.decompose({...}) of a grid takes the fields cells, lower, upper and cuts, in this order";
template <sentence S> struct no_grid {
  static_assert(unrefused<S>, "world.decompose({...}) of a grid takes the fields cells, lower, upper and cuts, in this order");
};
struct grid_fields {
  static constexpr auto says = grid;
  template <sentence S> using refused = no_grid<S>;
};
inline constexpr sentence rectilinear = "world.decompose({...}) of a rectilinear grid takes the fields x, y and z, in this order";
template <sentence S> struct no_rectilinear {
  static_assert(unrefused<S>, "world.decompose({...}) of a rectilinear grid takes the fields x, y and z, in this order");
};
struct rectilinear_fields {
  static constexpr auto says = rectilinear;
  template <sentence S> using refused = no_rectilinear<S>;
};
inline constexpr sentence bisection = "world.decompose({...}) of a bisection takes the fields count, lower, upper and cuts, in this order";
template <sentence S> struct no_bisection {
  static_assert(unrefused<S>, "world.decompose({...}) of a bisection takes the fields count, lower, upper and cuts, in this order");
};
struct bisection_fields {
  static constexpr auto says = bisection;
  template <sentence S> using refused = no_bisection<S>;
};
inline constexpr sentence slabs = "world.decompose({...}) of slabs takes the fields count, axis, lower, upper and cuts, in this order";
template <sentence S> struct no_slabs {
  static_assert(unrefused<S>, "world.decompose({...}) of slabs takes the fields count, axis, lower, upper and cuts, in this order");
};
struct slabs_fields {
  static constexpr auto says = slabs;
  template <sentence S> using refused = no_slabs<S>;
};
inline constexpr sentence ring = "world.decompose({...}) of a ring takes the fields sectors, axis, centre, start, angle, hub and closed, in this order";
template <sentence S> struct no_ring {
  static_assert(unrefused<S>, "world.decompose({...}) of a ring takes the fields sectors, axis, centre, start, angle, hub and closed, in this order");
};
struct ring_fields {
  static constexpr auto says = ring;
  template <sentence S> using refused = no_ring<S>;
};
inline constexpr sentence hexagonal = "world.decompose({...}) of hexagonal cells takes the fields rings, spacing, width, centre, axis and start, in this order";
template <sentence S> struct no_hexagonal {
  static_assert(unrefused<S>, "world.decompose({...}) of hexagonal cells takes the fields rings, spacing, width, centre, axis and start, in this order");
};
struct hexagonal_fields {
  static constexpr auto says = hexagonal;
  template <sentence S> using refused = no_hexagonal<S>;
};
inline constexpr sentence decomposition = "world.decompose({...}) takes the fields of its decomposition, which docs/policies/decomposition.md lists, in their order";
template <sentence S> struct no_decomposition {
  static_assert(unrefused<S>, "world.decompose({...}) takes the fields of its decomposition, which docs/policies/decomposition.md lists, in their order");
};
struct decomposition_fields {
  static constexpr auto says = decomposition;
  template <sentence S> using refused = no_decomposition<S>;
};
// clang-format on

/// The fields of a decomposition: its own, or a sentence that refers to them.
template <class Decomposition>
struct of_decomposition {
  using type = decomposition_fields;
};
template <class Decomposition>
requires requires { typename Decomposition::talus_fields; }
struct of_decomposition<Decomposition> {
  using type = typename Decomposition::talus_fields;
};

}  // namespace talus::detail::fields
