#pragma once
// A body as the user sees it: a light reference into the storage of its world, valid until bodies
// are added, removed, migrated or stepped.
#include <cmath>
#include <type_traits>

#include "talus/body/body.hpp"
#include "talus/features/sleeping/sleeping_islands.hpp"
#include "talus/ghosts/released.hpp"
#include "talus/scenario/scenario.hpp"
#include "talus/state/state.hpp"
#include "talus/world/sections.hpp"

namespace talus {

/// A body as for_each_local() and world[handle] give it: valid until bodies are added, removed or
/// stepped.
template <class Scenario, class Shape>
class body_view {
  using state_type = detail::world_state<Scenario>;
  using store_type = detail::body_store<Shape, typename Scenario::features>;

 public:
  using shape_type = Shape;
  using columns = typename store_type::list;

  body_view(state_type& s, const detail::open_sections& open, store_type& store, std::size_t index,
            bool global)
      : s_(&s), open_(&open), store_(&store), i_(index), global_(global) {}

  /// Number of the body, the same on all ranks.
  [[nodiscard]] system_id id() const { return store_->id[i_]; }
  /// A handle that refers to the body from step to step.
  [[nodiscard]] talus::handle<Shape> handle() const { return {id()}; }
  /// Whether this is a shadow copy of a body that another rank owns. False on exactly one rank for
  /// each body that is not global.
  [[nodiscard]] bool is_remote() const { return !global_ && i_ >= store_->locals; }
  /// Whether the body is known on all ranks.
  [[nodiscard]] bool is_global() const { return global_; }
  /// Whether the body cannot move.
  [[nodiscard]] bool is_fixed() const { return store_->fixed(i_); }
  /// Whether the body sleeps: its island is at rest and left out of the steps. Every rank that
  /// knows the body has this flag.
  [[nodiscard]] bool is_asleep() const {
    if constexpr (detail::require_feature<Scenario, sleeping>()) return store_->asleep(i_);
    return false;
  }

  /// Form and size.
  [[nodiscard]] const Shape& shape() const { return store_->shape[i_]; }
  /// Position of the centre of mass, length.
  [[nodiscard]] const vec3& position() const { return store_->position[i_]; }
  /// Velocity of the centre of mass, length per time.
  [[nodiscard]] const vec3& velocity() const { return store_->velocity[i_]; }
  /// Angular velocity in the world frame, radians per time.
  [[nodiscard]] const vec3& angular_velocity() const { return store_->angular_velocity[i_]; }
  /// The identity if this shape stores no orientation (see features<orientation>).
  [[nodiscard]] quat orientation() const { return store_->pose(i_).orientation; }
  /// Position and orientation.
  [[nodiscard]] talus::pose pose() const { return store_->pose(i_); }
  /// Material of the body: see world.materials().
  [[nodiscard]] material_id material() const { return store_->material[i_]; }
  /// Mass, also of a fixed body; 0 of a triangle_mesh.
  [[nodiscard]] real mass() const requires(Shape::finite) {
    return detail::mass_of(*store_, i_, s_->materials);
  }
  /// Principal moments of inertia in the frame of the body, also of a fixed body.
  [[nodiscard]] vec3 inertia() const requires(Shape::finite) { return mass() * shape().inertia(); }
  /// The number that the user assigned to it; features<user_ids>.
  [[nodiscard]] std::uint32_t user_id() const {
    if constexpr (detail::require_feature<Scenario, user_ids>()) return store_->user_id[i_];
    return 0;
  }

  /// The value of a column, such as one of a user-defined feature: docs/features.md.
  template <class Column>
  [[nodiscard]] const typename Column::value_type& get() const {
    static_assert(store_type::template has<Column>,
                  "bodies of this shape carry no such column: add the feature that has it to the "
                  "features<...> of the scenario");
    return store_->template column<Column>()[i_];
  }

  // Changes. Only the owner makes them: on a shadow copy they would be lost at the next migration,
  // so they throw logic_error there. A global body is changed alike on all ranks: logic_error in an
  // exclusive section. It has no velocity: setting one throws logic_error. Values that are not
  // finite: invalid_argument.

  /// Sets the value of a column of a user-defined feature.
  template <class Column>
  void set(const typename Column::value_type& value) {
    static_assert(store_type::template has<Column> && !detail::named_column<Column>,
                  "bodies of this shape carry no such column that can be set: add the feature that "
                  "has it to the features<...> of the scenario");
    prepare_change(Column::name, vec3(0, 0, 0));
    store_->template column<Column>()[i_] = value;
    if constexpr (detail::travel_of<Column>() == travels::when_changed) s_->note_filtered_change();
  }
  /// A fixed body stays in place, but carries along the bodies that touch it, as a belt does.
  void set_velocity(const vec3& v) {
    prepare_change("velocity", v);
    refuse_velocity();
    store_->velocity[i_] = v;
  }
  /// Sets the angular velocity in the world frame, radians per time.
  void set_angular_velocity(const vec3& w) {
    prepare_change("angular velocity", w);
    refuse_velocity();
    store_->angular_velocity[i_] = w;
  }
  /// Moves the centre of mass; it may land in the domain of any rank, to which the body migrates at
  /// the next migration.
  void translate(const vec3& by) {
    prepare_change("translation", by);
    store_->position[i_] += by;
    if constexpr (requires(Shape & infinite) { infinite.translate(by); })
      store_->shape[i_].translate(by);
    s_->template of<Shape>().globals_changed |= global_;
  }
  /// Rotates the body about its centre of mass, an infinite one about its position. The length of
  /// the quaternion has no effect, unless it is zero: invalid_argument.
  void rotate(const quat& by) {
    prepare_change("rotation", by.vec());
    if (!(by.norm() > 0) || !std::isfinite(by.norm()))
      detail::fail<std::invalid_argument>(
          "the rotation of body {} must be a unit quaternion, but its norm is {}", id(), by.norm());
    const quat turn = by.normalized();
    if constexpr (store_type::oriented)
      store_->orientation_of[i_] = (turn * store_->orientation_of[i_]).normalized();
    if constexpr (requires(Shape & infinite) { infinite.rotate(turn, vec3()); })
      store_->shape[i_].rotate(turn, position());
    s_->template of<Shape>().globals_changed |= global_;
  }
  /// Makes the body immovable. It keeps its mass for the time when it is released.
  void fix() {
    prepare_change("fixation", vec3(0, 0, 0));
    if constexpr (Shape::finite)
      if (!is_fixed() && mass() != s_->materials[material()].density * shape().volume())
        store_->keep_mass(i_, store_->inverse_mass[i_]);
    if constexpr (state_type::follows_contacts)
      if (!is_fixed()) detail::note_parted(*s_, id(), false);
    store_->flags[i_] |= detail::flag_fixed;
    store_->inverse_mass[i_] = 0;
    store_->velocity[i_].setZero();
    store_->angular_velocity[i_].setZero();
    s_->note_filtered_change();
    if constexpr (state_type::sleeps) detail::disturb(*s_, *store_, i_);
  }
  /// Makes a fixed body movable again. A global body stays fixed: logic_error.
  void release() requires(Shape::finite) {
    prepare_change("fixation", vec3(0, 0, 0));
    if constexpr (requires { Shape::immovable; })
      detail::fail<std::logic_error>("body {} is a {}, which has no mass and stays fixed", id(),
                                     Shape::name);
    if (global_)
      detail::fail<std::logic_error>(
          "global body {} cannot be made movable: global bodies are fixed and never local; add it "
          "outside of the global section instead",
          id());
    if (!is_fixed()) return;
    if constexpr (Scenario::contact_law::soft)
      detail::require_yielding<typename Scenario::contact_law::law, Shape>(
          s_->materials[material()]);
    store_->inverse_mass[i_] = store_->keeps_mass(i_) ? store_->kept.inverse_of(id()) : 1 / mass();
    store_->forget_mass(i_);
    store_->flags[i_] &= static_cast<std::uint8_t>(~detail::flag_fixed);
    s_->note_filtered_change();
    if constexpr (!state_type::link_type::alone)
      detail::note_release(*s_, *store_, i_);
    else
      detail::clear_history_of(*s_, id());
    if constexpr (state_type::sleeps) detail::disturb(*s_, *store_, i_);
  }
  /// Wakes the island of the body, and resets its rest time. (So does every change of a body except
  /// of its visibility.)
  void wake() requires(Shape::finite) {
    if constexpr (detail::require_feature<Scenario, sleeping>())
      prepare_change("rest", vec3(0, 0, 0));
  }
  /// Pictures omit invisible bodies; nothing else changes.
  void set_visible(bool visible) {
    if constexpr (detail::require_feature<Scenario, visibility>()) {
      prepare_change("visibility", vec3(0, 0, 0), false);
      if (visible)
        store_->flags[i_] &= static_cast<std::uint8_t>(~detail::flag_invisible);
      else
        store_->flags[i_] |= detail::flag_invisible;
    }
  }
  /// Whether pictures show the body.
  [[nodiscard]] bool is_visible() const { return !(store_->flags[i_] & detail::flag_invisible); }

  /// Adds a force on the centre of mass for the next step.
  void add_force(const vec3& force) {
    if constexpr (detail::require_feature<Scenario, forces>()) {
      prepare_change("force", force);
      store_->force[i_] += force;
    }
  }
  /// Adds a torque for the next step.
  void add_torque(const vec3& torque) {
    if constexpr (detail::require_feature<Scenario, forces>()) {
      prepare_change("torque", torque);
      store_->torque[i_] += torque;
    }
  }
  /// Adds a force that acts at a point of the world.
  void add_force_at(const vec3& force, const vec3& point) {
    add_force(force);
    add_torque((point - position()).cross(force));
  }

 private:
  void refuse_velocity() const {
    if (global_)
      detail::fail<std::logic_error>(
          "global body {} takes no velocity: it is fixed, so translate or rotate it, or add it "
          "outside of the global section",
          id());
  }
  void prepare_change(const char* what, const vec3& value, bool wakes = true) {
    if (!detail::finite(value))
      detail::fail<std::invalid_argument>("the {} of body {} must be finite, but is {}", what, id(),
                                          detail::text(value));
    if (is_remote())
      detail::fail<std::logic_error>(
          "the {} of body {} was changed on rank {}, which holds a shadow copy only, so the change "
          "would be lost: change it where is_remote() is false",
          what, id(), s_->link->rank());
    if (global_ && open_->exclusive)
      detail::fail<std::logic_error>(
          "the {} of global body {} was changed inside an exclusive section on rank {}, so the "
          "ranks "
          "would differ: change it on all ranks, outside of the section",
          what, id(), s_->link->rank());
    if (!global_) s_->changed = true;
    if constexpr (state_type::sleeps)
      if (wakes) detail::disturb(*s_, *store_, i_);
  }

  state_type* s_;
  const detail::open_sections* open_;
  store_type* store_;
  std::size_t i_;
  bool global_;
};

}  // namespace talus
