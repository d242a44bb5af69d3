#pragma once
// A union and any other shape: the contacts of its parts, one after the other.
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/collide_pair.hpp"
#include "talus/detect/pairs/sphere_sphere.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/union_of.hpp"

namespace talus {

namespace detail {

/// The pose of a part of a body; of a sphere the position alone.
template <class Part>
[[nodiscard, gnu::always_inline]] inline pose pose_of_part(const pose& body, const Part&,
                                                           const pose& at) {
  if constexpr (Part::isotropic)
    return {body.to_world(at.position), {1, 0, 0, 0}};
  else
    return combined(body, at);
}

/// Adds the number of a part to the features of its contacts.
template <class A, class B, class Sink>
void collide_parts(const A& a, const pose& pa, const B& b, const pose& pb, real margin,
                   std::uint64_t numbers, Sink& sink) {
  const auto named = [&](contact_geometry c) {
    c.feature |= numbers;
    sink(c);
  };
  collide_pair(a, pa, b, pb, margin, contact_sink(named));
}

}  // namespace detail

/// Calls `sink(contact_geometry)` for the points of each part with a gap of at most `margin`: up to
/// 16 a part. The feature holds the number of the part in bits 32 to 47. Points of one part that
/// lie inside another part are found like any others.
template <class... Parts, class B, class Sink>
requires(!detail::is_union<B> &&
         (... && collidable<Parts, B>)) void collide(const union_of<Parts...>& a, const pose& pa,
                                                     const B& b, const pose& pb, real margin,
                                                     Sink&& sink) {
  const auto part = [&](std::uint64_t n, const auto& shape, const pose& at) {
    detail::collide_parts(shape, detail::pose_of_part(pa, shape, at), b, pb, margin, n << 32, sink);
  };
  if constexpr (B::finite) {
    a.each_part_near(pa.to_body(pb.position), b.bounding_radius() + margin, part);
  } else {
    std::uint64_t n = 0;
    a.each_part([&](const auto& shape, const pose& at) { part(n++, shape, at); });
  }
}

namespace detail {

/// Up to this many parts of b near a, collide_spheres() does all; else it returns false.
inline constexpr std::size_t most_near_spheres = 64;

/// The contacts of two unions of spheres. The parts of b near the ball around a get places in the
/// world once, not for each part of a.
template <class Sink>
[[nodiscard]] bool collide_spheres(const union_of<sphere>& a, const pose& pa,
                                   const union_of<sphere>& b, const pose& pb, real margin,
                                   Sink& sink) {
  struct placed {
    vec3 centre;
    real radius;
    std::uint64_t number;
  };
  std::array<placed, most_near_spheres> near_a;
  std::size_t count = 0;
  b.each_part_near(pb.to_body(pa.position), a.bounding_radius() + margin,
                   [&](std::uint64_t n, const sphere& s, const pose& at) {
                     if (count < most_near_spheres)
                       near_a[count] = {pb.to_world(at.position), s.radius, n << 48};
                     ++count;
                   });
  if (count > most_near_spheres) return false;
  if (count == 0) return true;
  a.each_part_near(pa.to_body(pb.position), b.bounding_radius() + margin,
                   [&](std::uint64_t m, const sphere& s, const pose& at) {
                     const vec3 here = pa.to_world(at.position);
                     for (std::size_t k = 0; k < count; ++k) {
                       const placed& other = near_a[k];
                       touch_of_spheres<real> t(here, s.radius, other.centre, other.radius);
                       const real reach = t.touch + margin;
                       if (!(t.squared <= reach * reach)) continue;
                       t.find_point(other.centre, other.radius);
                       sink(contact_geometry{t.normal, t.point, t.gap, m << 32 | other.number});
                     }
                   });
  return true;
}

}  // namespace detail

/// Two unions: the contacts of all their parts that are near each other. The feature holds the
/// number of the part of a in bits 32 to 47, and that of b in bits 48 to 63.
template <class... Parts, class... Others, class Sink>
void collide(const union_of<Parts...>& a, const pose& pa, const union_of<Others...>& b,
             const pose& pb, real margin, Sink&& sink) {
  if constexpr ((... && std::is_same_v<Parts, sphere>)&&(... && std::is_same_v<Others, sphere>))
    if (detail::collide_spheres(a, pa, b, pb, margin, sink)) return;
  a.each_part_near(pa.to_body(pb.position), b.bounding_radius() + margin,
                   [&](std::uint64_t m, const auto& one, const pose& of_one) {
                     const pose here = detail::pose_of_part(pa, one, of_one);
                     b.each_part_near(
                         pb.to_body(here.position), one.bounding_radius() + margin,
                         [&](std::uint64_t n, const auto& other, const pose& of_other) {
                           detail::collide_parts(one, here, other,
                                                 detail::pose_of_part(pb, other, of_other), margin,
                                                 m << 32 | n << 48, sink);
                         });
                   });
}

}  // namespace talus
