#pragma once
// Whether the functions of a shape of a user's own are those of one convex body: its support
// function at sampled directions, its volume and its inertia. A mistake there would show as bodies
// that sink into each other, or that turn too slowly, far from its cause.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "talus/concepts.hpp"
#include "talus/core/error.hpp"
#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/shape/convex_form.hpp"
#include "talus/shape/detail/support_moments.hpp"
#include "talus/shape/polyhedron_mesh.hpp"

namespace talus {

struct sphere;
struct box;
struct capsule;
struct cylinder;
struct ellipsoid;
struct superellipsoid;
class convex_polyhedron;

}  // namespace talus

namespace talus::detail {

/// A shape behind the functions that are tested.
struct untested_shape {
  const void* shape;
  const char* name;
  real bounding_radius;
  vec3 (*support)(const void*, const vec3& direction);
  vec3 (*half_extents)(const void*, const pose& at);
};

/// Throws invalid_argument with the direction and the values unless, for 98 directions, support()
/// is the furthest of all points found, depends on no length, and lies within the bounds.
[[gnu::cold]] inline void require_convex_support(const untested_shape& s) {
  constexpr real small = 1e-6;
  const real slack = small * s.bounding_radius;
  if (!(s.bounding_radius > 0) || !std::isfinite(s.bounding_radius))
    fail<std::invalid_argument>(
        "bounding_radius() of a {} returns {}; return the distance of its furthest point from the "
        "centre of mass",
        s.name, s.bounding_radius);
  struct sample {
    vec3 direction, point;
    real reach = 0;  ///< of the point along the direction
  };
  const auto point_along = [&](const vec3& d) {
    const vec3 p = s.support(s.shape, d);
    if (!finite(p))
      fail<std::invalid_argument>(
          "the support function of a {} returns no point: support({}) is {}; return a point with "
          "finite coordinates for every direction, for the zero vector any point of the shape",
          s.name, d, p);
    return p;
  };
  std::array<sample, 98> samples;
  std::size_t count = 0;
  const auto even = [](int i) { return i % 2 == 0; };
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k) {
        const bool zero = i == 0 && j == 0 && k == 0;
        if (!zero && even(i) && even(j) && even(k)) continue;
        const vec3 d = vec3(i, j, k).normalized();
        if (zero) {
          (void)point_along(d);
          continue;
        }
        samples[count++] = {d, point_along(d), 0};
      }
  for (std::size_t k = 0; k < count; ++k) {
    sample& one = samples[k];
    one.reach = one.direction.dot(one.point);
    if (one.point.norm() > s.bounding_radius + slack)
      fail<std::invalid_argument>(
          "the point support({}) of a {} is {}, at {} from its centre of mass, but its "
          "bounding_radius() is {}; return the distance of its furthest point there",
          one.direction, s.name, one.point, one.point.norm(), s.bounding_radius);
    if (!(one.reach > 0))
      fail<std::invalid_argument>(
          "the point support({}) of a {} is {}, so that its centre of mass, the origin, is not "
          "inside; give its points as seen from the centre of mass",
          one.direction, s.name, one.point);
    for (const real length : {real(1e-3), real(1e3)}) {
      const vec3 d = length * one.direction, p = point_along(d);
      if (!(std::abs(one.direction.dot(p) - one.reach) <= slack))
        fail<std::invalid_argument>(
            "the support function of a {} depends on the length of the direction: support({}) is "
            "{}, but support({}) is {}; normalise the direction first",
            s.name, one.direction, one.point, d, p);
    }
  }
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t m = 0; m < count; ++m) {
      const sample &one = samples[k], &other = samples[m];
      const real reach = one.direction.dot(other.point);
      if (reach > one.reach + slack)
        fail<std::invalid_argument>(
            "the support function of a {} is not that of a convex body: support({}) is {}, but "
            "support({}) is {}, which lies further along the first direction, at {} instead of {}; "
            "return the furthest of all points of the body, and build a body that is not convex as "
            "a union_of convex ones",
            s.name, one.direction, one.point, other.direction, other.point, reach, one.reach);
    }
  for (const pose& at : {pose{}, pose{{0, 0, 0}, rotation({1, 2, 3}, real(0.7))}}) {
    const vec3 half = s.half_extents(s.shape, at);
    for (std::size_t k = 0; k < count; ++k) {
      const vec3 p = rotated(at.orientation, samples[k].point);
      for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(p[axis]) <= half[axis] + slack))
          fail<std::invalid_argument>(
              "the point support({}) of a {} is {} in the frame of the world if its orientation is "
              "({}, {}, {}, {}), but half_extents() of that pose returns {}; return half the edges "
              "of the box around the posed shape",
              samples[k].direction, s.name, p, at.orientation.w(), at.orientation.x(),
              at.orientation.y(), at.orientation.z(), half);
    }
  }
}

/// Throws invalid_argument, with the values, unless the volume, the centre of mass and the moments
/// per unit of mass are about those of the body of the support function: the volume to a tenth, the
/// moments to a quarter, the centre to a twentieth of the bounding radius.
[[gnu::cold]] inline void require_filled_shape(const untested_shape& s, real volume,
                                               const vec3& moments) {
  const real r = s.bounding_radius;
  const auto known = moments_by_support(
      [&](const vec3& d) -> vec3 { return s.support(s.shape, d) / s.bounding_radius; });
  constexpr const char* or_else =
      "if its mass is not spread evenly, as that of a hollow body, give it `static constexpr bool "
      "homogeneous = false;`";
  const real true_volume = known.mass * r * r * r;
  if (!(std::abs(volume - true_volume) <= real(0.1) * true_volume))
    fail<std::invalid_argument>(
        "volume() of a {} returns {}, but the body of its support function has about {}; return "
        "that, and {}",
        s.name, volume, true_volume, or_else);
  const vec3 centre = known.first / known.mass;
  if (!(centre.norm() <= real(0.05)))
    fail<std::invalid_argument>(
        "the centre of mass of a {} is the origin of its support function, but that of the body of "
        "this function lies at about {}; return points as seen from there, and {}",
        s.name, r * centre, or_else);
  const mat3 spread = known.second / known.mass;
  vec3 right;
  real mixed = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    right[i] = r * r * (spread(j, j) + spread(k, k));
    mixed = std::max(mixed, r * r * std::abs(spread(j, k)));
  }
  bool good = true;
  for (int i = 0; i < 3; ++i)
    good = good && std::abs(moments[i] - right[i]) <= real(0.25) * right[i];
  if (!good)
    fail<std::invalid_argument>(
        "inertia() of a {} returns {}, but the body of its support function has about {}; return "
        "the moments about the axes x, y and z per unit of mass, and {}",
        s.name, moments, right, or_else);
  if (!(mixed <= real(0.1) * right.maxCoeff()))
    fail<std::invalid_argument>(
        "the axes of a {} are not its principal axes of inertia: the body of its support function "
        "has the moments {} about them, and products of inertia of up to {}; turn its points to "
        "the principal axes, and {}",
        s.name, right, mixed, or_else);
}

/// How far a form reaches along a direction (unit), from the origin.
[[nodiscard]] inline real reach_along(const block_form& f, const vec3& d) {
  return d.cwiseAbs().dot(f.half);
}
[[nodiscard]] inline real reach_along(const segment_form& f, const vec3& d) {
  return std::abs(d[2]) * f.half + f.rounding;
}
[[nodiscard]] inline real reach_along(const drum_form& f, const vec3& d) {
  return portable::hypot(d[0], d[1]) * f.radius + std::abs(d[2]) * f.half;
}
[[nodiscard]] inline real reach_along(const ball_form& f, const vec3&) { return f.radius; }
[[nodiscard]] inline real reach_along(const mesh_form& f, const vec3& d) {
  return d.dot(f.mesh->vertices[f.mesh->furthest(d)]) + f.rounding;
}

/// Throws invalid_argument, with a direction and the values, unless form() reaches as far as
/// support() along 98 directions, to a thousandth of the bounding radius: contacts take the form,
/// bounds and rays the support function.
template <class Shape>
[[gnu::cold]] void require_form_of_support(const Shape& s) {
  const auto form = s.form();
  if constexpr (requires { reach_along(form, vec3{}); })
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        for (int k = -2; k <= 2; ++k) {
          if (i % 2 == 0 && j % 2 == 0 && k % 2 == 0) continue;
          const vec3 d = vec3(i, j, k).normalized();
          const real reach = reach_along(form, d), known = d.dot(s.support(d));
          if (!(std::abs(reach - known) <= real(1e-3) * s.bounding_radius()))
            fail<std::invalid_argument>(
                "form() of a {} reaches {} along {}, but its support function reaches {}; return "
                "the form of the same body, in the same frame",
                Shape::name, reach, d, known);
        }
}

/// Throws invalid_argument, with the values, for a volume and moments per unit of mass that no body
/// within the bounding radius can have, or that hardly any body has: less than a hundredth of those
/// of a ball of the volume.
[[gnu::cold]] inline void require_mass_of_shape(const char* name, real volume, const vec3& moments,
                                                real radius) {
  constexpr real slack = 1 + 1e-6;
  const real ball = 4 * pi / 3 * radius * radius * radius;
  if (!(volume > 0) || !std::isfinite(volume))
    fail<std::invalid_argument>(
        "volume() of a {} returns {}; return its volume, a finite number above 0, and choose units "
        "in which its size is nearer to 1 if this is beyond what numbers can hold",
        name, volume);
  if (!(volume <= ball * slack))
    fail<std::invalid_argument>(
        "volume() of a {} returns {}, and the ball of its bounding_radius(), {}, holds {} only; "
        "return its volume",
        name, volume, radius, ball);
  const auto refuse = [&](const std::string& why) {
    fail<std::invalid_argument>(
        "inertia() of a {} returns {}: {}; return its principal moments about the centre of mass, "
        "per unit of mass",
        name, moments, why);
  };
  for (int i = 0; i < 3; ++i) {
    const real one = moments[i], others = moments[(i + 1) % 3] + moments[(i + 2) % 3];
    if (!(one > 0) || !std::isfinite(one)) refuse("each must be a finite number above 0");
    if (!(one <= others * slack))
      refuse(
          compose("{} is more than the sum {} of the other two, which no distribution of mass "
                  "has",
                  one, others));
    if (!(one <= radius * radius * slack))
      refuse(
          compose("{} is more than {}, the square of its bounding_radius()", one, radius * radius));
  }
  const real size = std::cbrt(volume / (4 * pi / 3)), least = real(0.012) * size * size;
  if (moments[0] + moments[1] + moments[2] < least)
    refuse(compose("together less than {}, a hundredth of those of a ball of its volume", least));
}

/// The convex shapes of talus.
template <class Shape>
inline constexpr bool is_known_shape = false;
template <>
inline constexpr bool is_known_shape<talus::sphere> = true;
template <>
inline constexpr bool is_known_shape<talus::box> = true;
template <>
inline constexpr bool is_known_shape<talus::capsule> = true;
template <>
inline constexpr bool is_known_shape<talus::cylinder> = true;
template <>
inline constexpr bool is_known_shape<talus::ellipsoid> = true;
template <>
inline constexpr bool is_known_shape<talus::superellipsoid> = true;
template <>
inline constexpr bool is_known_shape<talus::convex_polyhedron> = true;

/// Whether a shape is tested when it is used: a convex one of a user's own.
template <class Shape>
inline constexpr bool is_tested_shape = concepts::convex_shape<Shape> && !is_known_shape<Shape>;
/// Whether the mass of a shape fills it evenly.
template <class Shape>
inline constexpr bool is_homogeneous = [] {
  if constexpr (requires { Shape::homogeneous; })
    return bool(Shape::homogeneous);
  else
    return true;
}();
/// Whether a shape, or a part of a union, is tested.
template <class Shape>
inline constexpr bool has_tested_shape = is_tested_shape<Shape>;
template <template <class...> class Union, class... Parts>
inline constexpr bool has_tested_shape<Union<Parts...>> = is_tested_shape<Union<Parts...>> ||
                                                          (... || is_tested_shape<Parts>);

/// Tests a shape, or the parts of a union: of each type the first 64 values that differ from the
/// one before, on each thread, and the mass against the support function of the first eight.
template <class Shape>
void require_convex(const Shape& s) {
  if constexpr (is_tested_shape<Shape>) {
    constexpr int values = 64, filled = 8;
    thread_local int left = values;
    thread_local Shape last;
    if (left == 0 || (left < values && s == last)) return;
    const untested_shape one{&s, Shape::name, s.bounding_radius(),
                             [](const void* shape, const vec3& d) -> vec3 {
                               return static_cast<const Shape*>(shape)->support(d);
                             },
                             [](const void* shape, const pose& at) -> vec3 {
                               return static_cast<const Shape*>(shape)->half_extents(at);
                             }};
    require_convex_support(one);
    require_mass_of_shape(Shape::name, s.volume(), s.inertia(), s.bounding_radius());
    if (is_homogeneous<Shape> && left > values - filled)
      require_filled_shape(one, s.volume(), s.inertia());
    if constexpr (requires { s.form(); }) require_form_of_support(s);
    last = s, --left;
  } else if constexpr (requires { s.each_part([](const auto&, const pose&) {}); }) {
    s.each_part([](const auto& part, const pose&) { require_convex(part); });
  }
}

}  // namespace talus::detail
