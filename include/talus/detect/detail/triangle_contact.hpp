#pragma once
// Contacts with a triangle of a surface: the nearest point, and the contact directions at an edge
// or a corner that belong to the surface. If a neighbouring triangle comes nearer in a direction,
// it belongs to this triangle but not to the surface, and must have no effect on a sliding body
// (internal edges; van den Bergen 2003, Collision Detection in Interactive 3D Environments, 6.3:
// normals outside the Voronoi region of their feature make no contacts).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/shape/nearest_on_triangle.hpp"
#include "talus/shape/triangle_tree.hpp"

namespace talus::detail {

/// Within the plane of triangle t, that has the edge from a to b: from the edge inwards, unit
/// length.
[[nodiscard]] inline vec3 inwards(const triangle_tree& m, std::uint32_t t, std::uint32_t a,
                                  std::uint32_t b) {
  std::uint32_t tip = a;
  for (const std::uint32_t v : m.triangles[t])
    if (v != a && v != b) tip = v;
  const vec3 along = (m.vertices[b] - m.vertices[a]).normalized();
  const vec3 across = m.vertices[tip] - m.vertices[a];
  return (across - along.dot(across) * along).normalized();
}

inline constexpr real level_enough = 1e-6;  ///< sine of an angle that counts as zero

/// Whether a triangle contains the point q, within `near`, and reaches further in the direction.
[[nodiscard]] inline bool reaches_further(const triangle_tree& m, std::uint32_t t, const vec3& q,
                                          const vec3& direction, real near) {
  const vec3 &a = m.corner(t, 0), &b = m.corner(t, 1), &c = m.corner(t, 2);
  if ((nearest_on_triangle(q, a, b, c).at - q).squaredNorm() > near * near) return false;
  for (const vec3* v : {&a, &b, &c})
    if (const vec3 way = *v - q; direction.dot(way) > level_enough * way.norm() + near) return true;
  return false;
}
/// Calls f(triangle, near) for the triangles other than t that may contain the point q within
/// `near`.
template <class F>
void each_other_at(const triangle_tree& m, std::uint32_t t, const vec3& q, F&& f) {
  const real near = real(1e-7) * m.bounding_radius;
  const vec3 reach(near, near, near);
  m.each_within(q - reach, q + reach, [&](std::uint32_t other) {
    if (other != t) f(other, near);
  });
}

/// Whether no triangle at the point q reaches further in the direction, other than t: for edges and
/// corners where triangles meet that do not share them.
[[nodiscard]] inline bool nearest_of_triangles(const triangle_tree& m, std::uint32_t t,
                                               const vec3& q, const vec3& direction) {
  bool nearest = true;
  each_other_at(m, t, q, [&](std::uint32_t other, real near) {
    nearest = nearest && !reaches_further(m, other, q, direction, near);
  });
  return nearest;
}

/// Whether another triangle at the point q reaches further in the direction, between triangle t and
/// the centre of a body, as the upper face of a closed surface does at its end.
[[nodiscard]] inline bool is_covered(const triangle_tree& m, std::uint32_t t, const vec3& q,
                                     const vec3& direction, const vec3& centre) {
  const vec3 own = (m.corner(t, 0) + m.corner(t, 1) + m.corner(t, 2)) / 3 - q, body = centre - q;
  bool covered = false;
  each_other_at(m, t, q, [&](std::uint32_t other, real near) {
    const real below = m.normals[other].dot(own), above = m.normals[other].dot(body);
    covered = covered || (below * above < 0 && std::abs(below) > level_enough * own.norm() &&
                          reaches_further(m, other, q, direction, near));
  });
  return covered;
}

[[nodiscard]] inline bool in_one_plane(const triangle_tree& m, std::uint32_t t,
                                       std::uint32_t other) {
  return m.normals[t].cross(m.normals[other]).norm() <= level_enough &&
         std::abs(m.normals[t].dot(m.corner(other, 0) - m.corner(t, 0))) <=
             level_enough * m.bounding_radius;
}
/// Whether the plane of triangle t goes on all around one of its edges or corners.
[[nodiscard]] inline bool goes_on_around(const triangle_tree& m, std::uint32_t t,
                                         const triangle_point& q) {
  const auto beyond = [&](std::uint32_t one, std::size_t edge) {
    const std::uint32_t other = m.neighbours[one][edge];
    return other != triangle_tree::none && in_one_plane(m, t, other) ? other : triangle_tree::none;
  };
  if (q.edge >= 0) return beyond(t, static_cast<std::size_t>(q.edge)) != triangle_tree::none;
  if (q.corner < 0) return false;
  const std::uint32_t vertex = m.triangles[t][static_cast<std::size_t>(q.corner)];
  std::uint32_t one = t, before = triangle_tree::none;
  for (int k = 0; k < 64; ++k) {  // around the corner, over the edges that end at it
    std::uint32_t next = triangle_tree::none;
    for (std::size_t edge = 0; edge < 3 && next == triangle_tree::none; ++edge) {
      const auto& corners = m.triangles[one];
      if (corners[edge] != vertex && corners[(edge + 1) % 3] != vertex) continue;
      if (const std::uint32_t other = beyond(one, edge); other != before) next = other;
    }
    if (next == triangle_tree::none || next == t) return next == t;
    before = std::exchange(one, next);
  }
  return false;
}
/// Another triangle with this point of triangle t, on an edge or at a corner, that has the normal
/// `direction` on one of its sides; none if there is none.
[[nodiscard]] inline std::uint32_t level_beside(const triangle_tree& m, std::uint32_t t,
                                                const triangle_point& q, const vec3& direction) {
  const auto is_level = [&](std::uint32_t other) {
    return m.normals[other].cross(direction).norm() <= level_enough;
  };
  if (q.edge >= 0) {
    const std::uint32_t beyond = m.neighbours[t][static_cast<std::size_t>(q.edge)];
    return beyond != triangle_tree::none && is_level(beyond) ? beyond : triangle_tree::none;
  }
  std::uint32_t found = triangle_tree::none;
  if (q.corner < 0) return found;
  const std::uint32_t vertex = m.triangles[t][static_cast<std::size_t>(q.corner)];
  each_other_at(m, t, m.vertices[vertex], [&](std::uint32_t other, real) {
    const auto& corners = m.triangles[other];
    if (std::find(corners.begin(), corners.end(), vertex) != corners.end() && is_level(other))
      found = std::min(found, other);
  });
  return found;
}
/// The distance of the point q from the nearest of those edges of triangle t over which the surface
/// does not go on in the same plane.
[[nodiscard]] inline real distance_to_bend(const triangle_tree& m, std::uint32_t t, const vec3& q) {
  real least = std::numeric_limits<real>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t beyond = m.neighbours[t][k];
    if (beyond != triangle_tree::none && in_one_plane(m, t, beyond)) continue;
    const vec3 &a = m.corner(t, k), &b = m.corner(t, (k + 1) % 3);
    const vec3 along = b - a;
    const real part = std::clamp(along.dot(q - a) / along.squaredNorm(), real(0), real(1));
    least = std::min(least, (q - a - part * along).norm());
  }
  return least;
}

/// The triangles near a body.
class triangles_near {
 public:
  void add(std::uint32_t t) {
    size_ < few_.size() ? void(few_[size_] = t) : more_.push_back(t);
    ++size_;
  }
  template <class F>
  void each(F&& f) const {
    for (std::size_t k = 0; k < size_; ++k) f(k < few_.size() ? few_[k] : more_[k - few_.size()]);
  }
  /// Whether the triangles in the plane of triangle t have at least this area together. The first
  /// planes that are asked for are remembered; where there are more, the surface is curved, and
  /// others count as narrow.
  [[nodiscard]] bool is_wide(const triangle_tree& m, std::uint32_t t, real area) {
    for (std::size_t k = 0; k < planes_; ++k)
      if (in_one_plane(m, plane_of_[k], t)) return wide_[k];
    if (planes_ == plane_of_.size()) return false;
    real sum = 0;
    each([&](std::uint32_t other) {
      if (in_one_plane(m, t, other))
        sum += real(0.5) *
               triangle_tree::twice_area(m.corner(other, 0), m.corner(other, 1), m.corner(other, 2))
                   .norm();
    });
    plane_of_[planes_] = t;
    return wide_[planes_++] = sum >= area;
  }
  /// distance_to_bend() of the plane of triangle t, as far as its triangles are near.
  [[nodiscard]] real distance_to_bend(const triangle_tree& m, std::uint32_t t,
                                      const vec3& q) const {
    real least = std::numeric_limits<real>::infinity();
    each([&](std::uint32_t other) {
      if (in_one_plane(m, t, other)) least = std::min(least, detail::distance_to_bend(m, other, q));
    });
    return least;
  }
  /// Whether the way of this length from the point q of triangle t, in the direction (unit), leads
  /// through another triangle that has all of t behind it: as from a side of a closed surface
  /// through its upper face, where both meet at less than a right angle (see triangle_tree::sharp),
  /// or from the lower face of a thin plate.
  [[nodiscard]] bool hide(const triangle_tree& m, std::uint32_t t, const vec3& q,
                          const vec3& direction, real length, real near) const {
    if (length <= near) return false;
    if (!m.sharp && !(m.normals[t].dot(direction) < 0)) return false;
    bool hidden = false;
    each([&](std::uint32_t other) {
      if (hidden || other == t) return;
      const vec3 &n = m.normals[other], &corner = m.corner(other, 0);
      const real from = n.dot(q - corner), rise = n.dot(direction);
      // Not in its plane, and towards it.
      if (std::abs(from) <= near || from * rise >= 0) return;
      if (const real way = std::abs(from); way > (length + near) * std::abs(rise)) return;
      for (std::size_t k = 0; k < 3; ++k)
        if (const real at = n.dot(m.corner(t, k) - corner); from < 0 ? at > near : at < -near)
          return;
      const vec3 p = q - (from / rise) * direction;
      const vec3 nearest =
          nearest_on_triangle(p, m.corner(other, 0), m.corner(other, 1), m.corner(other, 2)).at;
      hidden = (nearest - p).squaredNorm() <= near * near;
    });
    return hidden;
  }
  /// Whether one of the triangles that have the corner q comes nearer to the centre of a sphere, by
  /// a point at least `near` away: where corners are blunt, the ways along edges do not tell.
  [[nodiscard]] bool come_nearer(const triangle_tree& m, const vec3& q, const vec3& centre,
                                 real near) const {
    bool nearer = false;
    each([&](std::uint32_t t) {
      if (nearer) return;
      const vec3 &a = m.corner(t, 0), &b = m.corner(t, 1), &c = m.corner(t, 2);
      const vec3 foot = nearest_on_triangle(centre, a, b, c).at;
      nearer = (foot - q).squaredNorm() > near * near &&
               (foot - centre).squaredNorm() < (q - centre).squaredNorm() &&
               (nearest_on_triangle(q, a, b, c).at - q).squaredNorm() <= near * near;
    });
    return nearer;
  }

 private:
  std::array<std::uint32_t, 64> few_;  ///< the first of them
  plain_vector<std::uint32_t> more_;
  std::size_t size_ = 0;
  std::array<std::uint32_t, 8> plane_of_;  ///< a triangle of each plane
  std::array<bool, 8> wide_;
  std::size_t planes_ = 0;
};

/// Whether this point is the furthest of the surrounding surface in the direction (unit).
[[nodiscard]] inline bool nearest_of_surface(const triangle_tree& m, std::uint32_t t,
                                             const triangle_point& q, const vec3& direction) {
  if (q.edge >= 0) {
    const auto k = static_cast<std::size_t>(q.edge);
    const std::uint32_t a = m.triangles[t][k], b = m.triangles[t][(k + 1) % 3];
    const std::uint32_t beyond = m.neighbours[t][k];
    const vec3 along = m.vertices[b] - m.vertices[a];
    return std::abs(direction.dot(along)) <= level_enough * along.norm() &&
           direction.dot(inwards(m, t, a, b)) <= level_enough &&
           (beyond == triangle_tree::none
                ? nearest_of_triangles(m, t, q.at, direction)
                : direction.dot(inwards(m, beyond, a, b)) <= level_enough);
  }
  if (q.corner >= 0) {
    const std::uint32_t v = m.triangles[t][static_cast<std::size_t>(q.corner)];
    for (std::uint32_t n = m.around_begin[v]; n < m.around_begin[v + 1]; ++n) {
      const vec3 way = m.vertices[m.around[n]] - m.vertices[v];
      if (direction.dot(way) > level_enough * way.norm()) return false;
    }
    if (m.frayed[v]) return nearest_of_triangles(m, t, q.at, direction);
  }
  return true;
}

/// Points of edges and corners that have made a contact, so that the next triangle with the same
/// point does not repeat it.
class felt_points {
 public:
  explicit felt_points(real apart) : square_(apart * apart) {}
  /// Returns false if there was a contact at this place.
  bool add(const vec3& p) {
    for (std::size_t k = 0; k < size_; ++k)
      if ((points_[k] - p).squaredNorm() <= square_) return false;
    if (size_ < points_.size()) points_[size_++] = p;
    return true;
  }

 private:
  std::array<vec3, 32> points_;
  std::size_t size_ = 0;
  real square_;
};

/// The points of triangles that are nearest to the centre of a sphere, one for each place of the
/// surface: a triangle that has another of them within `near`, but comes nearer, has its own.
class sphere_feet {
 public:
  struct point {
    vec3 at, normal;
    real gap;
    std::uint32_t triangle;
    bool inside;  ///< of the triangle, not on its edge or at its corner
  };
  explicit sphere_feet(real near) : near_(near) {}
  /// Returns false if there is no room.
  bool add(const point& p) {
    if (size_ == points_.size()) return false;
    points_[size_++] = p;
    return true;
  }
  /// Calls f(triangle, normal, gap) for the points that are kept.
  template <class F>
  void each(const triangle_tree& m, F&& f) const {
    for (std::size_t k = 0; k < size_; ++k)
      if (const point& p = points_[k]; size_ == 1 || !is_repeated(m, k))
        f(p.triangle, p.normal, p.gap);
  }

 private:
  [[nodiscard]] bool is_repeated(const triangle_tree& m, std::size_t k) const {
    // Round-off has no effect on whether a point inside of a triangle is preferred.
    const auto height = [&](const point& p) { return p.gap - (p.inside ? real(1e-6) * near_ : 0); };
    const point& p = points_[k];
    for (std::size_t n = 0; n < size_; ++n) {
      const point& other = points_[n];
      const real higher = height(other) - height(p);
      if (n == k || higher > 0 || (higher == 0 && n > k)) continue;
      const std::uint32_t t = other.triangle;
      const vec3 way =
          nearest_on_triangle(p.at, m.corner(t, 0), m.corner(t, 1), m.corner(t, 2)).at - p.at;
      if (way.squaredNorm() <= near_ * near_) return true;
    }
    return false;
  }

  std::array<point, 32> points_;
  std::size_t size_ = 0;
  real near_;
};

}  // namespace talus::detail
