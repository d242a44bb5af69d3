#pragma once
// bodies<...>: the shapes of a scenario. Nothing is compiled or stored for other shapes.
#include <type_traits>

#include "talus/concepts.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

namespace detail {

template <class Shape>
struct is_shape : std::bool_constant<concepts::shape<Shape>> {};

template <class Shape>
struct part_of_bodies {
  static_assert(complete<Shape>,
                "bodies<...> names a shape whose header is missing: write #include "
                "<talus/mesh.hpp> for triangle_mesh");
  static_assert(!complete<Shape> || is_shape<Shape>::value,
                "bodies<...> takes shapes only, such as sphere, box or plane, and this type is "
                "not one: remove it, or make it model talus::concepts::shape");
};

}  // namespace detail

/// Policy: the shapes of all bodies. Default: bodies<sphere, plane>.
template <class... Shapes>
struct bodies final {
  static_assert((... && detail::examined<detail::part_of_bodies<Shapes>>));
  static_assert(sizeof...(Shapes) > 0,
                "bodies<> names no shape: name at least one, as in bodies<sphere>");
  static_assert(detail::all_different<type_list<Shapes...>>,
                "bodies<...> names a shape twice: keep one of the two");

  using talus_role = roles::bodies;
  /// Each shape once, and only shapes: a refused list causes no second error.
  using list = detail::filter_types<detail::unique_types<type_list<Shapes...>>, detail::is_shape>;

  static std::string describe() { return detail::describe_list<Shapes...>("bodies"); }
};

}  // namespace talus
