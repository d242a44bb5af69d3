#pragma once
// A half-space with a convex shape: the near points of the face or line that faces the plane most,
// or the lowest point of a smooth shape.
#include <array>
#include <cmath>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/convex_patch.hpp"
#include "talus/detect/pairs/convex_convex.hpp"
#include "talus/shape/plane.hpp"

namespace talus {

namespace detail {

/// The corners near a plane that lies `height` below the origin of the view's frame, at most 16.
template <class Real>
struct corners_near_plane {
  std::array<patch_point<Real>, outline<Real>::capacity> points;
  int size = 0;

  corners_near_plane(const convex_view<Real>& view, const vector3<Real>& up, Real height,
                     Real margin) {
    outline<Real> lowest;
    view.outline_along(-up, most_corners, lowest);
    const vector3<Real> any = vector3<Real>::Unit(std::abs(up[0]) < Real(0.6) ? 0 : 1);
    const vector3<Real> u = any.cross(up).normalized(), v = up.cross(u);
    for (int k = 0; k < lowest.size; ++k) {
      const auto& corner = lowest.corners[static_cast<std::size_t>(k)];
      const Real gap = height + up.dot(corner.at) - view.rounding();
      if (gap <= margin)
        points[static_cast<std::size_t>(size++)] = {u.dot(corner.at), v.dot(corner.at), gap, 0,
                                                    corner.code,      corner.at};
    }
    size = keep_outline<Real>(points.data(), size, Real(1e-4) * view.smallest());
  }
};

}  // namespace detail

/// Calls `sink(contact_geometry)` for the corners with a gap of at most `margin`, up to 16, the
/// lowest among them (within 1e-4 of the thickness); the feature is the number of the corner. A
/// cylinder that stands on a flat face has 16 fixed points of its edge circle, and carries loads
/// within 0.98 of its radius in all directions; if it leans by 2e-3 or more, the lowest point is
/// one of them.
template <class B, class Sink, class Real = real>
requires concepts::convex_shape<B>
void collide_convex(const plane& a, const pose&, const B& b, const pose& pb, real margin,
                    Sink&& sink) {
  const vector3<Real> up = a.unit_normal();
  const Real height = up.dot(pb.position) - a.offset;
  if (!(height - b.bounding_radius() <= margin)) return;
  const detail::convex_view<Real> view(detail::form_of(b), pose{vec3(0, 0, 0), pb.orientation});
  const detail::corners_near_plane<Real> near(view, up, height, margin);
  for (int k = 0; k < near.size; ++k) {
    const auto& p = near.points[static_cast<std::size_t>(k)];
    const vector3<Real> at = pb.position + p.at - (view.rounding() + Real(0.5) * p.height) * up;
    sink(contact_geometry{-up, at, p.height, p.incident});
  }
}

}  // namespace talus
