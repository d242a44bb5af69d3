#pragma once
// bodies<...>: the shapes of a scenario. Nothing is compiled or stored for other shapes.
#include <concepts>
#include <string_view>
#include <type_traits>

#include "talus/concepts.hpp"
#include "talus/core/policy.hpp"
#include "talus/core/type_list.hpp"

namespace talus {

namespace detail {

/// The parts of a shape, one by one, so that the compiler says which of them is missing.
template <class Shape>
struct parts_of_shape {
  static constexpr bool named = requires {
    { Shape::name } -> std::convertible_to<const char*>;
  };
  static constexpr bool bounded = requires {
    { Shape::finite } -> std::convertible_to<bool>;
    { Shape::isotropic } -> std::convertible_to<bool>;
  };
  static constexpr bool validated = requires(const Shape& s) {
    { s.validate() } -> std::same_as<void>;
  };
  static constexpr bool value = std::semiregular<Shape>;
  static constexpr bool supported = requires(const Shape& s, const vec3& v) {
    { s.support(v) } -> std::convertible_to<vec3>;
  };
  static constexpr bool reaching = requires(const Shape& s) {
    { s.bounding_radius() } -> std::convertible_to<real>;
  };
  static constexpr bool boxed = requires(const Shape& s, const pose& at) {
    { s.half_extents(at) } -> std::convertible_to<vec3>;
  };
  static constexpr bool massive = requires(const Shape& s) {
    { s.volume() } -> std::convertible_to<real>;
    { s.inertia() } -> std::convertible_to<vec3>;
  };
  static constexpr bool infinite = [] {
    if constexpr (bounded)
      return !Shape::finite;
    else
      return false;
  }();
  /// Whether the type is meant as a shape.
  static constexpr bool begun =
      named || bounded || validated || supported || reaching || boxed || massive;
};
/// What a shape of a user's own may lack. (In the order of `concepts::finite_shape`.)
template <class Shape>
struct own_shape {
  using has = parts_of_shape<Shape>;
  static_assert(has::value,
                "a shape of bodies<...> must be copied, compared with == and made without "
                "arguments: give its members defaults, and write friend bool operator==(const "
                "S&, const S&) = default");
  static_assert(has::named,
                "a shape of bodies<...> has no name: give it static constexpr const char* name = "
                "\"...\"");
  static_assert(has::bounded,
                "a shape of bodies<...> does not say whether it has a volume: give it static "
                "constexpr bool finite = true, isotropic = false");
  static_assert(has::validated,
                "a shape of bodies<...> does not check its numbers: give it void validate() "
                "const, which throws invalid_argument for wrong ones");
  static_assert(has::supported || has::infinite,
                "a shape of bodies<...> has no support function: give it vec3 support(const "
                "vec3& direction) const, a point furthest along a direction of any length");
  static_assert(has::reaching || has::infinite,
                "a shape of bodies<...> has no bounding radius: give it real bounding_radius() "
                "const, the distance of its furthest point from the centre of mass");
  static_assert(has::boxed || has::infinite,
                "a shape of bodies<...> has no bounding box: give it vec3 half_extents(const "
                "pose& at) const, half the edges of the box around the posed shape");
  static_assert(has::massive || has::infinite,
                "a shape of bodies<...> has no mass properties: give it real volume() const and "
                "vec3 inertia() const, the principal moments per unit of mass");
};

/// Unions of any parts have one name, and files number them.
template <class Shape>
concept parts_of_union = requires(const Shape& s) {
  s.each_part([](const auto&, const pose&) {});
};

template <class Shape>
struct is_shape : std::bool_constant<concepts::finite_shape<Shape> ||
                                     (concepts::shape<Shape> && parts_of_shape<Shape>::infinite)> {
};

template <class Shape>
struct part_of_bodies {
  static_assert(complete<Shape>,
                "bodies<...> names a shape whose header is missing: write #include "
                "<talus/mesh.hpp> for triangle_mesh");
  static constexpr bool begun = complete<Shape> && parts_of_shape<Shape>::begun;
  static_assert(sizeof(std::conditional_t<begun, own_shape<Shape>, std::true_type>) > 0);
  static_assert(!complete<Shape> || begun || is_shape<Shape>::value,
                "bodies<...> takes shapes only, such as sphere, box or plane, and this type is "
                "not one: remove it, or make it model talus::concepts::shape");
};

/// Whether two shapes that are not unions have one name.
template <class A, class B>
inline constexpr bool share_name = [] {
  if constexpr (std::is_same_v<A, B> || !complete<A> || !complete<B>) {
    return false;
  } else if constexpr (parts_of_shape<A>::named && parts_of_shape<B>::named) {
    constexpr std::string_view a = A::name, b = B::name;
    return a == b && !(parts_of_union<A> && parts_of_union<B>);
  } else {
    return false;
  }
}();
template <class Shape, class... Others>
inline constexpr bool has_name_of_another = (... || share_name<Shape, Others>);

}  // namespace detail

/// Policy: the shapes of all bodies. Default: bodies<sphere, plane>.
template <class... Shapes>
struct bodies final {
  static_assert((... && (sizeof(detail::examined<detail::part_of_bodies, Shapes>) > 0)));
  static_assert(sizeof...(Shapes) > 0,
                "bodies<> names no shape: name at least one, as in bodies<sphere>");
  static_assert(detail::all_different<type_list<Shapes...>>,
                "bodies<...> names a shape twice: keep one of the two");
  static_assert(!(... || detail::has_name_of_another<Shapes, Shapes...>),
                "two shapes of bodies<...> have the same name, by which files distinguish them: "
                "change the static constexpr const char* name of one");

  using talus_role = roles::bodies;
  /// Each shape once, and only shapes: a refused list causes no second error.
  using list = detail::filter_types<detail::unique_types<type_list<Shapes...>>, detail::is_shape>;

  static std::string describe() { return detail::describe_list<Shapes...>("bodies"); }
};

}  // namespace talus
