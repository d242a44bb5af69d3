#pragma once
// Bodies as rows of an output: one for each body, or for each part of a union.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "talus/core/type_list.hpp"
#include "talus/io/detail/row_table.hpp"
#include "talus/io/detail/shape_numbers.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/union_of.hpp"
#include "talus/world/world.hpp"

namespace talus::detail {

/// Lengths of a shape along the axes of its body: the scale factors for a sphere, box or cylinder
/// of size 1.
template <class Shape>
[[nodiscard]] vec3 size_of(const Shape& s) {
  const vec3 half = s.half_extents(pose{});
  return 2 * half;
}
template <class Shape>
[[nodiscard]] real radius_of(const Shape& s) {
  if constexpr (requires { s.radius; })
    return s.radius;
  else
    return s.bounding_radius();
}

/// The output form of the values of a column: as numbers, or as vectors of three.
template <class Column>
[[nodiscard]] consteval number_type vtk_type_of() {
  using value = typename Column::value_type;
  if constexpr (std::is_same_v<value, double> || std::is_same_v<value, vec3>)
    return number_type::f64;
  else if constexpr (std::is_same_v<value, float>)
    return number_type::f32;
  else if constexpr (std::is_same_v<value, std::uint64_t>)
    return number_type::u64;
  else if constexpr (std::is_same_v<value, std::int64_t>)
    return number_type::i64;
  else if constexpr (std::is_same_v<value, std::uint32_t>)
    return number_type::u32;
  else if constexpr (std::is_same_v<value, std::uint16_t>)
    return number_type::u16;
  else
    return number_type::u8;
}
template <class Column>
[[nodiscard]] consteval std::uint32_t vtk_width_of() {
  using value = typename Column::value_type;
  static_assert(std::is_same_v<value, double> || std::is_same_v<value, vec3> ||
                    std::is_same_v<value, float> || std::is_same_v<value, std::uint64_t> ||
                    std::is_same_v<value, std::int64_t> || std::is_same_v<value, std::uint32_t> ||
                    std::is_same_v<value, std::uint16_t> || std::is_same_v<value, std::uint8_t>,
                "this column cannot be output, since its values are neither numbers nor vec3: give "
                "it `static constexpr bool in_output = false`");
  return std::is_same_v<value, vec3> ? 3 : 1;
}

/// The columns of an output of this scenario: fewer if there is nothing to write.
template <class Scenario>
struct vtk_columns {
  template <class Shape>
  struct of_shape {
    using store = body_store<Shape, typename Scenario::features>;
    static constexpr bool oriented = store::oriented;
    static constexpr bool in_parts = is_union<Shape>;
  };
  template <class Shape>
  struct is_oriented : std::bool_constant<of_shape<Shape>::oriented> {};
  template <class Shape>
  struct is_in_parts : std::bool_constant<of_shape<Shape>::in_parts> {};
  using shapes = typename Scenario::shapes;

  static constexpr bool oriented = filter_types<shapes, is_oriented>::size > 0;
  static constexpr bool in_parts = filter_types<shapes, is_in_parts>::size > 0;
  /// Columns that are output unchanged, of any shape.
  template <class Shape>
  using shown_of = typename columns_by_use<typename of_shape<Shape>::store::list>::shown;
  template <class Shapes>
  struct shown_of_shapes;
  template <class... Shapes>
  struct shown_of_shapes<type_list<Shapes...>> {
    using type = sorted_columns<join_lists<shown_of<Shapes>...>>;
  };
  using shown = typename shown_of_shapes<shapes>::type;
  static constexpr bool sleeps = Scenario::template has_feature<sleeping>;
};

/// Calls f(shape, pose, number) for the shape of body i, or for each part of a union.
template <class Store, class F>
void each_part_of(const Store& store, std::size_t i, F&& f) {
  const auto& shape = store.shape[i];
  if constexpr (is_union<typename Store::shape_type>) {
    std::uint32_t part = 0;
    shape.each_part(
        [&](const auto& one, const pose& at) { f(one, combined(store.pose(i), at), part++); });
  } else {
    f(shape, store.pose(i), std::uint32_t{0});
  }
}

/// The tables of points and of their data, with the same rows.
template <class Scenario>
class vtk_bodies {
  using columns = vtk_columns<Scenario>;

 public:
  vtk_bodies() {
    points.column("Points", number_type::f64, 3);
    data.column("id", number_type::u64)
        .column("rank", number_type::u32)
        .column("shape", number_type::u8)
        .column("fixed", number_type::u8)
        .column("material", number_type::u16)
        .column("mass", number_type::f64)
        .column("radius", number_type::f64)
        .column("size", number_type::f64, 3)
        .column("velocity", number_type::f64, 3)
        .column("angular_velocity", number_type::f64, 3);
    if constexpr (columns::oriented) data.column("orientation", number_type::f64, 4);
    if constexpr (columns::in_parts) data.column("part", number_type::u32);
    add_columns(typename columns::shown{});
    if constexpr (columns::sleeps) data.column("asleep", number_type::u8);
  }

  /// All bodies that this rank owns, and on rank 0 the finite global ones.
  void add_all(const population<Scenario>& s) {
    s.each_finite_shape([&](auto& b) {
      const auto rank = static_cast<std::uint32_t>(s.link->rank());
      for (std::size_t i = 0; i < b.movable.locals; ++i) add(s, b.movable, i, rank);
      if (rank == 0)
        for (std::size_t i = 0; i < b.global.size(); ++i) add(s, b.global, i, rank);
    });
  }

  row_table points{"/VTKHDF"}, data{"/VTKHDF/PointData"};
  shape_numbers shapes{typename Scenario::shapes{}};

 private:
  template <class... Columns>
  void add_columns(type_list<Columns...>) {
    (data.column(Columns::name, vtk_type_of<Columns>(), vtk_width_of<Columns>()), ...);
  }
  /// A shape that does not carry the column has its default.
  template <class... Columns, class Store>
  void put_columns(type_list<Columns...>, const Store& store, std::size_t i) {
    [[maybe_unused]] const auto put = [&]<class Column>(type_list<Column>) {
      if constexpr (Store::template has<Column>)
        data.put(store.template column<Column>()[i]);
      else
        data.put(initial_of<Column>());
    };
    (put(type_list<Columns>{}), ...);
  }
  template <class Store>
  void add(const held_bodies<Scenario>& s, const Store& store, std::size_t i, std::uint32_t rank) {
    each_part_of(store, i, [&](const auto& shape, const pose& at, std::uint32_t part) {
      add_one(s, store, i, rank, shape, at, part);
    });
  }
  template <class Store, class Shape>
  void add_one(const held_bodies<Scenario>& s, const Store& store, std::size_t i,
               std::uint32_t rank, const Shape& shape, const pose& at, std::uint32_t part) {
    const row_table::key key{value_of(store.id[i]), part, 0};
    const vec3 w = store.angular_velocity[i];
    const vec3 v = store.velocity[i] + w.cross(at.position - store.position[i]);
    points.begin_row(key);
    points.put(at.position);
    data.begin_row(key);
    data.put(value_of(store.id[i]));
    data.put(rank);
    data.put(shapes.number(Shape::name));
    data.put(static_cast<std::uint8_t>(store.fixed(i)));
    data.put(static_cast<std::uint16_t>(store.material[i]));
    const double mass = mass_of(store, i, s.materials);
    data.put(part == 0 ? mass : 0.0);
    data.put(radius_of(shape));
    data.put(size_of(shape));
    data.put(v);
    data.put(w);
    if constexpr (columns::oriented) {
      const quat& q = at.orientation;
      data.put(q.w(), q.x(), q.y(), q.z());
    }
    if constexpr (columns::in_parts) data.put(part);
    put_columns(typename columns::shown{}, store, i);
    if constexpr (columns::sleeps) data.put(static_cast<std::uint8_t>(store.asleep(i)));
  }
};

}  // namespace talus::detail
