#pragma once
// The convex hull of points in space, its faces as polygons: gift wrapping (Chand, Kapur 1970), in
// which points within round-off of a face's plane belong to that face. A tree over the points finds
// the next plane around an edge and the points in it, so a face costs the logarithm of the number
// of points instead of all of them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/shape/detail/point_tree.hpp"

namespace talus::detail {

/// Corners of the faces as numbers of points, counterclockwise as seen from outside.
using hull_faces = std::vector<plain_vector<std::uint32_t>>;

template <class Real>
class hull_wrapper {
  using vector = vector3<Real>;
  using polygon = plain_vector<std::uint32_t>;

 public:
  /// `tolerance` is the distance (of points about one unit apart) that counts as zero.
  hull_wrapper(const plain_vector<vector>& points, Real tolerance)
      : points_(points), tree_(points), tolerance_(tolerance) {}

  /// Returns nothing if the points lie in a plane, or if the tolerance leads to contradictions.
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
    const auto corner = points_[p];
    struct place {
      Real x = 0, y = 0;
    };
    place best;
    // Turns the plane around the line to the next point that it meets, from any plane to one beyond
    // which no point lies. Points on the line and in the plane of `normal` do not count.
    const auto turn = [&](const vector& direction, Real bx, Real by, Real height) {
      const Real before = height;
      place next;
      tree_.find_highest(direction, corner, 4 * tolerance_, height, [&](std::uint32_t i) {
        const vector v = points_[i] - corner;
        const Real x = v.dot(out), y = std::min(v.dot(normal), Real(0));
        const bool counts =
            x * x + y * y > 4 * tolerance_ * tolerance_ && !(x < 0 && y > -tolerance_);
        const Real above = bx * y - by * x;
        if (!counts || !(above > height)) return -std::numeric_limits<Real>::infinity();
        next = {x, y};
        return above;
      });
      if (height > before) best = next;
      return height > before;
    };
    if (!turn(out, 0, -1, -std::numeric_limits<Real>::infinity())) return {};
    for (bool turned = true; turned;) {
      const Real length = portable::hypot(best.x, best.y), bx = best.x / length,
                 by = best.y / length;
      turned = turn(bx * normal - by * out, bx, by, rounding);
    }
    const Real bx = best.x, by = best.y;
    plane_set set{(bx * normal - by * out).normalized(), {}};
    for (int round = 0; round < 2; ++round) {
      set.members = members_of(set.normal, p);
      const polygon corners = outline(set);
      if (corners.size() < 3) break;
      const vector better = area_of(corners).normalized();
      if (!(better.dot(set.normal) > Real(0.9))) break;
      set.normal = better;
    }
    return set;
  }

  /// Points in or beyond the plane through point p, in their order.
  [[nodiscard]] plain_vector<std::uint32_t> members_of(const vector& normal,
                                                       std::uint32_t p) const {
    plain_vector<std::uint32_t> members;
    tree_.each_beyond(normal, points_[p], -tolerance_,
                      [&](std::uint32_t i) { members.push_back(i); });
    std::sort(members.begin(), members.end());
    return members;
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
  /// Returns what beyond() does, where points to both sides of the line in the plane itself may be
  /// the answer.
  [[nodiscard]] std::optional<plane_set> beyond_flat(std::uint32_t p, const vector& line,
                                                     const vector& normal) const {
    plane_set flat{normal, members_of(normal, p)};
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
      Real first = 0;
    };
    plain_vector<place> places;
    for (const auto i : set.members) places.push_back({u.dot(points_[i]), v.dot(points_[i]), i});
    std::sort(places.begin(), places.end(), [](auto& a, auto& b) { return a.x < b.x; });
    // Points with the same x up to the tolerance are ordered by y, or the chain turns back at them.
    for (std::size_t k = 0; k < places.size(); ++k)
      places[k].first = k > 0 && places[k].x - places[k - 1].first <= tolerance_
                            ? places[k - 1].first
                            : places[k].x;
    std::sort(places.begin(), places.end(), [](auto& a, auto& b) {
      return a.first != b.first ? a.first < b.first : a.y != b.y ? a.y < b.y : a.point < b.point;
    });
    plain_vector<place> ring;
    const auto add = [&](const place& c, std::size_t keep) {
      while (ring.size() >= keep + 2) {
        const place &a = ring[ring.size() - 2], &b = ring.back();
        const Real dx = c.x - a.x, dy = c.y - a.y;
        if ((b.x - a.x) * dy - (b.y - a.y) * dx < -tolerance_ * portable::hypot(dx, dy)) break;
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

  /// Precision of the heights of points about one unit away.
  static constexpr Real rounding = 4 * std::numeric_limits<Real>::epsilon();

  const plain_vector<vector>& points_;
  point_tree<Real> tree_;
  Real tolerance_;
  hull_faces faces_;
  plain_vector<vector> normals_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_;  ///< edges of the faces so far
};

/// The hull of any points; empty if they do not span space. Points closer to each other than two
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
  plain_vector<vector> all;
  for (const vector& p : points) all.push_back((p - middle) / extent);
  const point_tree<Real> tree(all);
  // Faces between points that lie very close on a curved surface differ by less than the first.
  for (const Real tolerance :
       {Real(5e-7), Real(2e-6), Real(1e-5), Real(1e-9), Real(1e-11), Real(1e-13)}) {
    plain_vector<vector> scaled;
    plain_vector<std::uint32_t> number;
    plain_vector<char> kept(all.size(), 0);
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      bool twice = false;
      tree.each_near(all[i], 4 * tolerance, [&](std::uint32_t j) {
        twice = twice || (kept[j] && (all[j] - all[i]).squaredNorm() <= 16 * tolerance * tolerance);
      });
      if (twice) continue;
      kept[i] = 1;
      scaled.push_back(all[i]), number.push_back(i);
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
