#pragma once
// Moves the corners of triangles that lie in one plane but for round-off into that plane. Without
// it a thin triangle is tilted as far as the round-off of its corners over its height.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/core/plain_pair.hpp"
#include "talus/core/plain_vector.hpp"
#include "talus/core/sort.hpp"
#include "talus/shape/triangle_tree.hpp"

namespace talus::detail {

class triangle_leveller {
  using corners = triangle_tree::corners;
  static constexpr std::uint32_t none = triangle_tree::none;

 public:
  /// Triangles that share corners, about the origin. Corners may deviate from a plane by `near`;
  /// planes of which they deviate by less than `exact` need no change.
  triangle_leveller(plain_vector<vec3>& points, const plain_vector<corners>& faces, real near,
                    real exact)
      : points_(points), faces_(faces), near_(near), exact_(exact) {}

  /// Returns the number of corners that were moved.
  std::size_t level() {
    connect();
    region_.assign(faces_.size(), none);
    plain_vector<plain_pair<real, std::uint32_t>> largest_first;
    for (std::uint32_t t = 0; t < faces_.size(); ++t)
      largest_first.push_back({-twice_area(t).norm(), t});
    sort_values(largest_first);
    for (const auto& [area, t] : largest_first)
      if (region_[t] == none) grow(t);
    return rough_ ? move_corners() : 0;
  }

 private:
  struct plane {
    vec3 normal;
    real offset;
    bool rough = false;  ///< corners deviate from it
    [[nodiscard]] real height(const vec3& p) const { return normal.dot(p) - offset; }
  };

  [[nodiscard]] const vec3& corner(std::uint32_t t, std::size_t k) const {
    return points_[faces_[t][k]];
  }
  [[nodiscard]] vec3 twice_area(std::uint32_t t) const {
    return triangle_tree::twice_area(corner(t, 0), corner(t, 1), corner(t, 2));
  }
  /// Finds the triangles beyond each edge: those of an edge lie in a ring.
  void connect() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, plain_pair<std::uint32_t, std::uint32_t>>
        ends;
    next_.assign(3 * faces_.size(), none);
    for (std::uint32_t t = 0; t < faces_.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t a = faces_[t][k], b = faces_[t][(k + 1) % 3], side = 3 * t + k;
        auto [at, added] = ends.try_emplace({std::min(a, b), std::max(a, b)}, side, side);
        next_[at->second.second] = side, next_[side] = at->second.first;
        at->second.second = side;
      }
  }
  /// The plane through the middle of some triangles, with the normal that their rim determines.
  [[nodiscard]] plane fitted(const plain_vector<std::uint32_t>& members, const vec3& up) const {
    vec3 sum(0, 0, 0), middle(0, 0, 0);
    real area = 0;
    for (const std::uint32_t t : members) {
      vec3 twice = twice_area(t);
      if (twice.dot(up) < 0) twice = -twice;
      const real size = twice.norm();
      sum += twice, area += size;
      middle += (size / 3) * (corner(t, 0) + corner(t, 1) + corner(t, 2));
    }
    const vec3 normal = sum.normalized();
    return {normal, normal.dot(middle / area)};
  }
  [[nodiscard]] real largest_height(const plane& p, std::uint32_t t) const {
    real most = 0;
    for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(p.height(corner(t, k))));
    return most;
  }
  /// The triangles without a region around `seed` that lie in the plane.
  void reach(std::uint32_t seed, const plane& p, plain_vector<std::uint32_t>& members) {
    members.assign(1, seed);
    const auto number = static_cast<std::uint32_t>(planes_.size());
    region_[seed] = number;
    for (std::size_t k = 0; k < members.size(); ++k)
      for (std::uint32_t side = 3 * members[k]; side < 3 * members[k] + 3; ++side)
        for (std::uint32_t other = next_[side]; other != side; other = next_[other])
          if (const std::uint32_t t = other / 3;
              region_[t] == none && largest_height(p, t) <= near_)
            region_[t] = number, members.push_back(t);
  }
  /// Makes the region of a triangle. Its plane follows from its members, which are found anew.
  void grow(std::uint32_t seed) {
    constexpr int most = 8;
    plain_vector<std::uint32_t> members, last;
    plane p = fitted({seed}, twice_area(seed));
    for (int k = 0; k < most; ++k) {
      reach(seed, p, members);
      if (members.size() <= last.size()) break;
      for (const std::uint32_t t : members) region_[t] = none;
      last = members;
      p = fitted(members, p.normal);
    }
    for (const std::uint32_t t : members) region_[t] = none;
    for (const std::uint32_t t : last) region_[t] = static_cast<std::uint32_t>(planes_.size());
    p.rough = last.size() > 1 && is_rough(p, last);
    rough_ = rough_ || p.rough;
    planes_.push_back(p);
    sizes_.push_back(last.size());
  }
  /// Whether corners deviate from the plane by round-off, not by the form of the surface: they tilt
  /// single triangles by far more than a surface that bends by as much over the width of the
  /// region, and each in another direction than the triangles beside it.
  [[nodiscard]] bool is_rough(const plane& p, const plain_vector<std::uint32_t>& members) const {
    constexpr real far_more = 16;  // a parabola: 4
    const vec3& origin = corner(members[0], 0);
    const auto normal_of = [&](std::uint32_t t) {
      const vec3 n = twice_area(t).normalized();
      return n.dot(p.normal) < 0 ? vec3(-n) : n;
    };
    real deviation = 0, tilt = 0, length = 0, tilts = 0, turns = 0;
    vec3 along(0, 0, 0);
    for (const std::uint32_t t : members) {
      deviation = std::max(deviation, largest_height(p, t));
      const vec3 normal = normal_of(t);
      vec3 beside(0, 0, 0);
      for (std::uint32_t side = 3 * t; side < 3 * t + 3; ++side)
        for (std::uint32_t other = next_[side]; other != side; other = next_[other])
          if (region_[other / 3] == region_[t]) beside += normal_of(other / 3);
      const real own = (normal - p.normal).norm();
      tilt = std::max(tilt, own), tilts += own;
      turns += (normal - beside.normalized()).norm();
      for (std::size_t k = 0; k < 3; ++k)
        if (const vec3 way = corner(t, k) - origin; way.norm() > length)
          length = way.norm(), along = way;
    }
    if (!(deviation > exact_ && deviation <= 2 * near_)) return false;
    const vec3 across = p.normal.cross(along).normalized();
    real low = 0, high = 0;
    for (const std::uint32_t t : members)
      for (std::size_t k = 0; k < 3; ++k) {
        const real at = across.dot(corner(t, k) - origin);
        low = std::min(low, at), high = std::max(high, at);
      }
    return tilt * (high - low) > far_more * deviation && turns > real(0.5) * tilts;
  }
  /// Moves each corner of a rough plane into all planes that meet there, or leaves it where these
  /// are almost parallel.
  std::size_t move_corners() {
    plain_vector<plain_pair<std::uint32_t, std::uint32_t>> meeting;  // corner, plane
    for (std::uint32_t t = 0; t < faces_.size(); ++t)
      if (sizes_[region_[t]] > 1)
        for (const std::uint32_t v : faces_[t]) meeting.push_back({v, region_[t]});
    sort_values(meeting);
    const plain_vector<vec3> given = points_;
    for (std::size_t first = 0, last = 0; first < meeting.size(); first = last) {
      while (last < meeting.size() && meeting[last].first == meeting[first].first) ++last;
      bool rough = false;
      for (std::size_t k = first; k < last; ++k) rough = rough || planes_[meeting[k].second].rough;
      if (!rough) continue;
      vec3& at = points_[meeting[first].first];
      vec3 p = at;
      constexpr int most = 100;
      for (int round = 0; round < most; ++round) {
        const vec3 before = p;
        for (std::size_t k = first; k < last; ++k) {
          const plane& of = planes_[meeting[k].second];
          p -= of.height(p) * of.normal;
        }
        if ((p - before).norm() <= exact_) break;
      }
      if ((p - at).norm() <= 2 * near_) at = p;
    }
    while (put_back(given)) {
    }
    std::size_t moved = 0;
    for (std::size_t v = 0; v < points_.size(); ++v) moved += points_[v] != given[v];
    return moved;
  }
  /// Puts the corners of triangles back that would turn or collapse. Returns whether there were
  /// any.
  bool put_back(const plain_vector<vec3>& given) {
    bool any = false;
    for (std::uint32_t t = 0; t < faces_.size(); ++t) {
      const corners& f = faces_[t];
      if (points_[f[0]] == given[f[0]] && points_[f[1]] == given[f[1]] &&
          points_[f[2]] == given[f[2]])
        continue;
      const vec3 now = twice_area(t);
      const vec3 before = triangle_tree::twice_area(given[f[0]], given[f[1]], given[f[2]]);
      const real least = planes_[region_[t]].rough ? real(0.9) : real(0.995);
      if (now.dot(before) > least * now.norm() * before.norm() &&
          now.norm() > real(0.5) * before.norm())
        continue;
      for (const std::uint32_t v : f) any = any || points_[v] != given[v], points_[v] = given[v];
    }
    return any;
  }

  plain_vector<vec3>& points_;
  const plain_vector<corners>& faces_;
  real near_, exact_;
  plain_vector<std::uint32_t> next_;    ///< side 3 t + k of triangle t after another on one edge
  plain_vector<std::uint32_t> region_;  ///< of each triangle
  plain_vector<plane> planes_;          ///< of each region
  plain_vector<std::size_t> sizes_;     ///< triangles in it
  bool rough_ = false;
};

}  // namespace talus::detail
