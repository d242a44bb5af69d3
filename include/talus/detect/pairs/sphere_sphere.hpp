#pragma once
// Two spheres: one contact on the line of centres. Reads no orientation.
#include "talus/contact/contact_geometry.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"
#include "talus/shape/sphere.hpp"

namespace talus {

namespace detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The contact of two spheres, or of several pairs of them at once.
template <class Number>
struct touch_of_spheres {
  vectors_of<Number> difference;  ///< of the centres, a - b
  Number squared, touch;          ///< square of their distance, and the distance at touch
  vectors_of<Number> normal, point;
  Number gap;

  [[gnu::always_inline]] touch_of_spheres(const vectors_of<Number>& a, const Number& radius_a,
                                          const vectors_of<Number>& b, const Number& radius_b)
      : difference(a - b), squared(dot(difference, difference)), touch(radius_a + radius_b) {}
  /// Concentric spheres are pushed apart along z.
  [[gnu::always_inline]] void find_point(const vectors_of<Number>& b, const Number& radius_b) {
    const Number distance = square_root(squared);
    normal =
        choose(squared > real(1e-200), vectors_of<Number>(Number(real(1) / distance) * difference),
               every_lane_of<Number>(0, 0, 1));
    gap = distance - touch;
    point = b + Number(radius_b + real(0.5) * gap) * normal;
  }
};

#pragma GCC diagnostic pop

}  // namespace detail

/// Calls `sink(contact_geometry)` if the gap is at most `margin`. Concentric spheres are pushed
/// apart along z.
template <class Sink>
void collide(const sphere& a, const pose& pa, const sphere& b, const pose& pb, real margin,
             Sink&& sink) {
  detail::touch_of_spheres<real> t(pa.position, a.radius, pb.position, b.radius);
  const real reach = t.touch + margin;
  if (!(t.squared <= reach * reach)) return;
  t.find_point(pb.position, b.radius);
  sink(contact_geometry{t.normal, t.point, t.gap, 0});
}

}  // namespace talus
