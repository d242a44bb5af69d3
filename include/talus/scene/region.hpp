#pragma once
// Regions to fill with sites: boxes, cylinders, balls, and those of geometry/; all have bounds.
#include <limits>
#include <utility>
#include <vector>

#include "talus/core/portable_powers.hpp"
#include "talus/scene/site.hpp"

namespace talus {

namespace detail {

/// Bounds of a region. A prism is the same at every height between its lowest and highest points.
struct region_extent {
  vec3 lower = detail::thrice<real>(-unlimited);
  vec3 upper = detail::thrice<real>(unlimited);
  bool prism = true;
};

}  // namespace detail

/// A box between two corners, boundary included; a coordinate may be infinite.
struct box_region {
  vec3 lower;  ///< corner with the smallest coordinates
  vec3 upper;  ///< corner with the largest

  /// Depth of a point inside, negative outside.
  [[nodiscard]] real value(const vec3& p) const;
  /// Whether a point is inside or on the boundary.
  [[nodiscard]] bool contains(const vec3& p) const { return detail::between(lower, p, upper); }
  [[nodiscard]] detail::region_extent extent() const { return {lower, upper, true}; }
};

/// A cylinder about an axis parallel to z, boundary included; infinite without `lower` and
/// `upper`.
struct vertical_cylinder {
  real radius = 1;                  ///< length
  vec3 centre{0, 0, 0};             ///< any point of the axis
  real lower = -detail::unlimited;  ///< lowest z
  real upper = detail::unlimited;   ///< highest z

  /// Depth of a point inside, negative outside.
  [[nodiscard]] real value(const vec3& p) const;
  /// Whether a point is inside or on the boundary.
  [[nodiscard]] bool contains(const vec3& p) const;
  [[nodiscard]] detail::region_extent extent() const;
};

/// A ball about a point, boundary included.
struct ball_region {
  real radius = 1;       ///< length
  vec3 centre{0, 0, 0};  ///< of the ball

  /// Depth of a point inside, negative outside.
  [[nodiscard]] real value(const vec3& p) const { return radius - (p - centre).norm(); }
  /// Whether a point is inside or on the boundary.
  [[nodiscard]] bool contains(const vec3& p) const { return value(p) >= 0; }
  [[nodiscard]] detail::region_extent extent() const;
};

namespace detail {

/// Computes the bounds of a geometry from its planes perpendicular to an axis.
class extent_finder {
 public:
  void open(bool all_of);
  template <class HalfSpace>
  void plane(const HalfSpace& h) {
    const vec3 n = h.normal();
    region_extent e;
    for (int axis = 0; axis < 3; ++axis) {
      if (n[(axis + 1) % 3] != 0 || n[(axis + 2) % 3] != 0) continue;
      (n[axis] > 0 ? e.lower : e.upper)[axis] = n[axis] > 0 ? h.displacement() : -h.displacement();
    }
    const bool level = n[0] == 0 && n[1] == 0;
    for (const group& g : path_) e.prism = e.prism && (n[2] == 0 || (level && g.all_of));
    add(e);
  }
  void close();
  [[nodiscard]] const region_extent& extent() const { return path_.front().extent; }

 private:
  struct group {
    bool all_of = true;
    region_extent extent;
  };
  void add(const region_extent& e);
  std::vector<group> path_{1};
};

template <class Region>
[[nodiscard]] region_extent extent_of(const Region& region) {
  if constexpr (requires { region.extent(); }) {
    return region.extent();
  } else if constexpr (requires(extent_finder f) { region.describe(f); }) {
    extent_finder finder;
    region.describe(finder);
    return finder.extent();
  } else {
    return {.prism = false};  // unknown: another region must give the bounds
  }
}

/// The intersection of two regions.
template <class A, class B>
struct both_regions {
  A a;
  B b;

  [[nodiscard]] bool contains(const vec3& p) const { return a.contains(p) && b.contains(p); }
  [[nodiscard]] region_extent extent() const {
    const region_extent x = extent_of(a), y = extent_of(b);
    return {detail::upper_of(x.lower, y.lower), detail::lower_of(x.upper, y.upper),
            x.prism && y.prism};
  }
};

}  // namespace detail
}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/region_definitions.hpp"
#endif
