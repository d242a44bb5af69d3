#pragma once
// A body as the hooks of a user-defined feature see it at a stage of the step.
#include <cstddef>
#include <stdexcept>
#include <type_traits>

#include "talus/body/column.hpp"
#include "talus/body/mass.hpp"
#include "talus/body/material.hpp"
#include "talus/core/error.hpp"
#include "talus/core/id.hpp"
#include "talus/core/math.hpp"
#include "talus/core/type_list.hpp"
#include "talus/state/state.hpp"

namespace talus {

/// A body at a stage of the step. `Columns` are those that the feature may write.
template <class Scenario, class Store, class Columns>
class stage_body {
  using store_type = std::remove_const_t<Store>;
  using state_type = std::conditional_t<std::is_const_v<Store>, const detail::world_state<Scenario>,
                                        detail::world_state<Scenario>>;

 public:
  using shape_type = typename store_type::shape_type;

  stage_body(state_type& s, Store& store, std::size_t i, bool global, std::size_t number)
      : s_(s), store_(store), i_(i), global_(global), number_(number) {}

  /// Number of the body, the same on all ranks.
  [[nodiscard]] system_id id() const { return store_.id[i_]; }
  /// The index of the body among all bodies known here, from 0 to stage_view::bodies() - 1.
  [[nodiscard]] std::size_t number() const { return number_; }
  /// Whether this rank owns it.
  [[nodiscard]] bool is_local() const { return !global_ && i_ < store_.locals; }
  /// Whether it is known on all ranks.
  [[nodiscard]] bool is_global() const { return global_; }
  /// Whether it can move.
  [[nodiscard]] bool is_fixed() const { return global_ || store_.fixed(i_); }
  /// Form and size.
  [[nodiscard]] const shape_type& shape() const { return store_.shape[i_]; }
  /// Position of the centre of mass, length.
  [[nodiscard]] const vec3& position() const { return store_.position[i_]; }
  /// Velocity of the centre of mass, length over time.
  [[nodiscard]] const vec3& velocity() const { return store_.velocity[i_]; }
  /// World frame, radians over time.
  [[nodiscard]] const vec3& angular_velocity() const { return store_.angular_velocity[i_]; }
  /// Position and orientation.
  [[nodiscard]] talus::pose pose() const { return store_.pose(i_); }
  /// The material of the body.
  [[nodiscard]] const talus::material& material() const {
    return s_.materials[store_.material[i_]];
  }
  /// Also of a fixed body.
  [[nodiscard]] real mass() const requires(shape_type::finite) {
    return detail::mass_of(store_, i_, s_.materials);
  }
  /// The value of a column; its default if this shape does not carry it.
  template <class Column>
  [[nodiscard]] typename Column::value_type get() const {
    if constexpr (store_type::template has<Column>)
      return store_.template column<Column>()[i_];
    else
      return detail::initial_of<Column>();
  }
  /// Sets the value of a column of the feature, of a body that this rank owns. Shadow copies
  /// receive it at the next exchange, if the column is sent to them. In a scenario with a hook
  /// may_touch, throws logic_error for a column that travels when_changed from the last exchange
  /// before contacts are found (at_start; of velocity_verlet after_share) until after_detect.
  template <class Column>
  void set(const typename Column::value_type& value) const requires(!std::is_const_v<Store>) {
    static_assert(detail::contains_type<Columns, Column>,
                  "a hook sets columns of its own feature: add the column to its `columns`");
    store_.template column<Column>()[i_] = value;
    if constexpr (detail::travel_of<Column>() == travels::when_changed) {
      if constexpr (detail::world_state<Scenario>::filters)
        if (s_.filtered.sent)
          detail::fail<std::logic_error>(
              "a hook has set the column {} of body {} before the contacts of the step are found, "
              "but neighbours receive it after that, so that ranks would differ about which bodies "
              "touch: set it at after_detect or a later stage",
              Column::name, id());
      s_.changed = true;
      s_.note_filtered_change();
    }
  }

 private:
  state_type& s_;
  Store& store_;
  std::size_t i_;
  bool global_;
  std::size_t number_;
};

}  // namespace talus
