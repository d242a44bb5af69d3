#pragma once
// Well-known features that talus lacks, under their usual names: the line that names one is refused
// by a sentence. g++ shows the namespaces of a type whose braces it refuses, so they say it, too.
// Remove a name from here when talus gets the feature.

#define TALUS_REFUSED_NAME(says) __attribute__((unavailable(says)))

namespace talus {

struct motors;
struct cohesion;
inline namespace talus_calls_superquadrics_superellipsoid {
struct superquadric;
}
inline namespace talus_has_no_height_fields_take_a_triangle_mesh {
struct height_field;
}

namespace detail {

/// Types that are refused where they are named cause no second error in lists of policies.
template <class>
inline constexpr bool is_missing = false;
template <>
inline constexpr bool is_missing<motors> = true;
template <>
inline constexpr bool is_missing<cohesion> = true;
template <>
inline constexpr bool is_missing<superquadric> = true;
template <>
inline constexpr bool is_missing<height_field> = true;

}  // namespace detail

struct TALUS_REFUSED_NAME(
    "motors belong to joints: name the joint in joints<...> and set its motor, as in hinge{.motor "
    "= {...}}; docs/joints.md says how") motors final {};
struct TALUS_REFUSED_NAME(
    "talus has no part 'cohesion': hard_contact<...> takes normal_cohesion, soft_contact<...> "
    "takes jkr_adhesion, dmt_adhesion, linear_cohesion, cohesive_spring or van_der_waals of "
    "<talus/adhesion.hpp>, see docs/adhesion.md") cohesion final {};
inline namespace talus_calls_superquadrics_superellipsoid {
struct TALUS_REFUSED_NAME(
    "talus calls superquadrics superellipsoid, with radii and the exponents n1 and n2 from 2 to 8: "
    "write superellipsoid, see docs/policies/shapes.md") superquadric final {};
}  // namespace talus_calls_superquadrics_superellipsoid
inline namespace talus_has_no_height_fields_take_a_triangle_mesh {
struct TALUS_REFUSED_NAME("talus has no height fields: take a triangle_mesh, see docs/not_there.md")
    height_field final {};
}  // namespace talus_has_no_height_fields_take_a_triangle_mesh

// Where its header is missing, compilers show this line.
class triangle_mesh;  // write #include <talus/mesh.hpp>

}  // namespace talus
