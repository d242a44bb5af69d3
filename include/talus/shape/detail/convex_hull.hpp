#pragma once
// The convex hull of points in space, its faces as polygons: gift wrapping (Chand, Kapur 1970), in
// which points within round-off of a face's plane belong to that face.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"

namespace talus::detail {

/// Corners of the faces as numbers of points, counterclockwise as seen from outside.
using hull_faces = std::vector<plain_vector<std::uint32_t>>;

template <class Real>
class hull_wrapper {
  using vector = vector3<Real>;
  using polygon = plain_vector<std::uint32_t>;

 public:
  /// `tolerance` is the distance (of points about one unit apart) that counts as none.
  hull_wrapper(const plain_vector<vector>& points, Real tolerance)
      : points_(points), tolerance_(tolerance) {}

  /// Nothing where the points lie in a plane, or where the tolerance leads to contradictions.
  [[nodiscard]] std::optional<hull_faces> wrap() {
    const auto start = first_face();
    if (!start || !take(*start)) return {};
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (f > 4 * points_.size()) return {};
      const polygon face = faces_[f];
      const vector normal = normals_[f];
      for (std::size_t k = 0; k < face.size(); ++k) {
        const auto p = face[k], q = face[(k + 1) % face.size()];
        if (directed_.contains({q, p})) continue;
        const auto next = beyond(p, points_[q] - points_[p], normal);
        if (!next || !take(*next) || !directed_.contains({q, p})) return {};
      }
    }
    for (const auto& [edge, face] : directed_)
      if (!directed_.contains({edge.second, edge.first})) return {};
    return faces_.size() < 4 ? std::nullopt : std::optional(faces_);
  }

 private:
  struct plane_set {
    vector normal;
    plain_vector<std::uint32_t> members;
  };

  /// The supporting plane next to the plane with `normal` around the line through point p.
  [[nodiscard]] std::optional<plane_set> beyond(std::uint32_t p, const vector& line,
                                                const vector& normal) const {
    const vector along = line.normalized(), out = along.cross(normal).normalized();
    Real bx = 0, by = 0;
    bool found = false;
    for (const vector& r : points_) {
      const vector v = r - points_[p];
      const Real x = v.dot(out), y = std::min(v.dot(normal), Real(0));
      if (x * x + y * y <= 4 * tolerance_ * tolerance_) continue;
      if (x < 0 && y > -tolerance_) continue;  // in the plane we come from
      if (!found || bx * y - by * x > 0) bx = x, by = y, found = true;
    }
    if (!found) return {};
    plane_set set{(bx * normal - by * out).normalized(), {}};
    for (int round = 0; round < 2; ++round) {
      set.members.clear();
      for (std::uint32_t i = 0; i < points_.size(); ++i)
        if (set.normal.dot(points_[i] - points_[p]) >= -tolerance_) set.members.push_back(i);
      const polygon corners = outline(set);
      if (corners.size() < 3) break;
      const vector better = area_of(corners).normalized();
      if (!(better.dot(set.normal) > Real(0.9))) break;
      set.normal = better;
    }
    return set;
  }

  [[nodiscard]] std::optional<plane_set> first_face() const {
    std::uint32_t lowest = 0;
    for (std::uint32_t i = 1; i < points_.size(); ++i)
      if (points_[i][0] < points_[lowest][0]) lowest = i;
    auto set = beyond_flat(lowest, vector(0, 1, 0), vector(-1, 0, 0));
    if (set && outline(*set).size() < 3) {
      // The plane touches along a line: turn it about that line.
      std::uint32_t end = lowest;
      for (const auto i : set->members)
        if ((points_[i] - points_[lowest]).norm() > (points_[end] - points_[lowest]).norm())
          end = i;
      if (end == lowest) return {};
      set = beyond_flat(lowest, points_[end] - points_[lowest], set->normal);
    }
    return set;
  }
  /// As beyond(), where points to both sides of the line in the plane itself may be the answer.
  [[nodiscard]] std::optional<plane_set> beyond_flat(std::uint32_t p, const vector& line,
                                                     const vector& normal) const {
    plane_set flat{normal, {}};
    for (std::uint32_t i = 0; i < points_.size(); ++i)
      if (normal.dot(points_[i] - points_[p]) >= -tolerance_) flat.members.push_back(i);
    if (outline(flat).size() >= 3) return flat;
    return beyond(p, line, normal);
  }

  /// Hull of the members in their plane (Andrew 1979), without corners on straight lines.
  [[nodiscard]] polygon outline(const plane_set& set) const {
    const vector& n = set.normal;
    vector u = vector::Unit(std::abs(n[0]) < Real(0.6) ? 0 : 1);
    u = (u - u.dot(n) * n).normalized();
    const vector v = n.cross(u);
    struct place {
      Real x, y;
      std::uint32_t point;
    };
    plain_vector<place> places;
    for (const auto i : set.members) places.push_back({u.dot(points_[i]), v.dot(points_[i]), i});
    std::sort(places.begin(), places.end(),
              [](auto& a, auto& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    plain_vector<place> ring;
    const auto add = [&](const place& c, std::size_t keep) {
      while (ring.size() >= keep + 2) {
        const place &a = ring[ring.size() - 2], &b = ring.back();
        const Real dx = c.x - a.x, dy = c.y - a.y;
        if ((b.x - a.x) * dy - (b.y - a.y) * dx < -tolerance_ * std::hypot(dx, dy)) break;
        ring.pop_back();
      }
      ring.push_back(c);
    };
    // Clockwise in (x, y) with this sign of turn, so walk backwards at the end.
    for (const place& c : places) add(c, 0);
    const std::size_t half = ring.size() - 1;
    for (std::size_t i = places.size() - 1; i-- > 0;) add(places[i], half);
    if (ring.size() > 1) ring.pop_back();
    polygon corners;
    for (std::size_t i = ring.size(); i-- > 0;) corners.push_back(ring[i].point);
    if (corners.size() < 3) return {};
    return corners;
  }
  [[nodiscard]] vector area_of(const polygon& corners) const {
    vector area = vector::Zero();
    for (std::size_t k = 1; k + 1 < corners.size(); ++k)
      area += (points_[corners[k]] - points_[corners[0]])
                  .cross(points_[corners[k + 1]] - points_[corners[0]]);
    return area;
  }

  bool take(const plane_set& set) {
    polygon corners = outline(set);
    if (corners.size() < 3) return false;
    for (std::size_t k = 0; k < corners.size(); ++k)
      if (!directed_.emplace(std::pair{corners[k], corners[(k + 1) % corners.size()]}, 0).second)
        return false;
    normals_.push_back(area_of(corners).normalized());
    faces_.push_back(std::move(corners));
    return true;
  }

  const plain_vector<vector>& points_;
  Real tolerance_;
  hull_faces faces_;
  plain_vector<vector> normals_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_;  ///< edges of the faces so far
};

/// The hull of any points; empty where they do not span space. Points closer to each other than two
/// millionths of the extent are one, and faces flat within half a millionth are one.
template <class Real>
[[nodiscard]] hull_faces convex_hull(const plain_vector<vector3<Real>>& points) {
  using vector = vector3<Real>;
  if (points.size() < 4) return {};
  vector low = points[0], high = points[0];
  for (const vector& p : points) low = lower_of(low, p), high = upper_of(high, p);
  const vector middle = (low + high) / 2;
  const Real extent = (high - low).maxCoeff();
  if (!(extent > 0)) return {};
  for (const Real tolerance : {Real(5e-7), Real(2e-6), Real(1e-5), Real(1e-9)}) {
    plain_vector<vector> scaled;
    plain_vector<std::uint32_t> number;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const vector p = (points[i] - middle) / extent;
      const bool twice = std::any_of(scaled.begin(), scaled.end(), [&](const vector& other) {
        return (other - p).squaredNorm() <= 16 * tolerance * tolerance;
      });
      if (!twice) scaled.push_back(p), number.push_back(i);
    }
    if (scaled.size() < 4) continue;
    auto found = hull_wrapper<Real>(scaled, tolerance).wrap();
    if (!found) continue;
    for (auto& face : *found)
      for (auto& corner : face) corner = number[corner];
    return *found;
  }
  return {};
}

}  // namespace talus::detail
