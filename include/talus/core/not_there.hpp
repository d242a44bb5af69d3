#pragma once
// Well-known features that talus lacks, under their usual names. A scenario that names one gets a
// sentence that refers to docs/not_there.md instead of an undeclared name. Remove a name from here
// when talus gets the feature.

namespace talus {

namespace detail {

template <class>
inline constexpr bool is_there = false;

}  // namespace detail

struct motors final {
  template <class T>
  struct refusal {
    static_assert(detail::is_there<T>,
                  "motors belong to joints: name the joint in joints<...> and set its motor, as in "
                  "hinge{.motor = {...}}; docs/joints.md says how");
  };
};
struct cohesion final {
  template <class T>
  struct refusal {
    static_assert(
        detail::is_there<T>,
        "talus has no part 'cohesion': hard_contact<...> takes normal_cohesion, soft_contact<...> "
        "takes jkr_adhesion, dmt_adhesion, "
        "linear_cohesion, cohesive_spring or van_der_waals of <talus/adhesion.hpp>, see "
        "docs/adhesion.md");
  };
};
struct ellipsoid final {
  template <class T>
  struct refusal {
    static_assert(
        detail::is_there<T>,
        "talus has no ellipsoids: docs/not_there.md says what to take instead, and which code has");
  };
};
struct superquadric final {
  template <class T>
  struct refusal {
    static_assert(detail::is_there<T>,
                  "talus has no superquadrics: docs/not_there.md says what to take instead, and "
                  "which code has");
  };
};
struct height_field final {
  template <class T>
  struct refusal {
    static_assert(detail::is_there<T>,
                  "talus has no height fields: take a triangle_mesh, see docs/not_there.md");
  };
};

namespace detail {

template <class>
inline constexpr bool is_missing = false;
template <>
inline constexpr bool is_missing<motors> = true;
template <>
inline constexpr bool is_missing<cohesion> = true;
template <>
inline constexpr bool is_missing<ellipsoid> = true;
template <>
inline constexpr bool is_missing<superquadric> = true;
template <>
inline constexpr bool is_missing<height_field> = true;

}  // namespace detail

}  // namespace talus
