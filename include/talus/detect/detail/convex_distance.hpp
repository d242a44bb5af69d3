#pragma once
// The distance of two convex cores that are apart, and their nearest points: the algorithm of
// Gilbert, Johnson and Keerthi (1988) on the difference of the two.
#include <cmath>
#include <limits>

#include "talus/detect/detail/convex_view.hpp"

namespace talus::detail {

/// Points of a and b, and their difference: a point of the difference a - b.
template <class Real>
struct difference_point {
  vector3<Real> a, b, w;
};

/// Two posed shapes, a shifted by `shift`.
template <class Real>
struct convex_pair {
  const convex_view<Real>& a;
  const convex_view<Real>& b;
  vector3<Real> shift = vector3<Real>::Zero();

  /// The point of a - b furthest along a direction.
  [[nodiscard]] difference_point<Real> support(const vector3<Real>& d) const {
    difference_point<Real> p;
    p.a = a.support(d) + shift;
    p.b = b.support(-d);
    p.w = p.a - p.b;
    return p;
  }
  /// Gap of the cores along a unit direction from b to a: a larger gap separates them better; it is
  /// at most their distance.
  [[nodiscard]] Real gap_along(const vector3<Real>& n) const { return n.dot(support(-n).w); }
};

/// The part of a simplex nearest to the origin: corners with their weights.
template <class Real>
class simplex {
  using vector = vector3<Real>;

 public:
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] const difference_point<Real>& corner(int i) const { return points_[i]; }
  [[nodiscard]] Real weight(int i) const { return weights_[i]; }
  [[nodiscard]] bool contains(const vector& w) const {
    for (int i = 0; i < size_; ++i)
      if (points_[i].w == w) return true;
    return false;
  }
  /// Adds a corner and drops those that the nearest point does not need. With four left, the origin
  /// is inside, which is ruled out if it is known to be `outside`.
  void add(const difference_point<Real>& p, bool outside) {
    points_[size_++] = p;
    if (size_ == 1)
      keep({{0}, {1}, 1, p.w});
    else if (size_ == 2)
      keep(on_segment(0, 1));
    else if (size_ == 3)
      keep(on_triangle(0, 1, 2));
    else
      reduce_tetrahedron(outside);
  }
  /// The simplex after body a has moved by a vector.
  [[nodiscard]] simplex moved(const vector& by) const {
    simplex s;
    for (int i = 0; i < size_; ++i)
      s.add({points_[i].a + by, points_[i].b, points_[i].w + by}, true);
    return s;
  }
  [[nodiscard]] const vector& nearest() const { return nearest_; }
  [[nodiscard]] vector on_a() const { return sum(&difference_point<Real>::a); }
  [[nodiscard]] vector on_b() const { return sum(&difference_point<Real>::b); }

 private:
  struct part {
    int corner[3];
    Real weight[3];
    int size;
    vector nearest;
  };

  [[nodiscard]] vector sum(vector difference_point<Real>::*which) const {
    vector total = vector::Zero();
    for (int i = 0; i < size_; ++i) total += weights_[i] * (points_[i].*which);
    return total;
  }
  void keep(const part& p) {
    difference_point<Real> kept[3];
    for (int i = 0; i < p.size; ++i) kept[i] = points_[p.corner[i]];
    size_ = p.size;
    for (int i = 0; i < size_; ++i) points_[i] = kept[i], weights_[i] = p.weight[i];
    nearest_ = p.nearest;
  }
  [[nodiscard]] part on_segment(int i, int j) const {
    const vector &a = points_[i].w, &b = points_[j].w, ab = b - a;
    const Real along = -a.dot(ab), square = ab.squaredNorm();
    if (!(along > 0)) return {{i}, {1}, 1, a};
    if (along >= square) return {{j}, {1}, 1, b};
    const Real t = along / square;
    return {{i, j}, {1 - t, t}, 2, a + t * ab};
  }
  /// By signed areas, and along the normal: this stays exact for the thin triangles that round
  /// surfaces make.
  [[nodiscard]] part on_triangle(int i, int j, int k) const {
    const vector &a = points_[i].w, &b = points_[j].w, &c = points_[k].w;
    const vector n = (b - a).cross(c - a);
    const Real square = n.squaredNorm();
    const Real wa = n.dot(b.cross(c)), wb = n.dot(c.cross(a)), wc = n.dot(a.cross(b));
    const bool flat = !(square > Real(1e-30) * (b - a).squaredNorm() * (c - a).squaredNorm());
    if (!flat && wa > 0 && wb > 0 && wc > 0) {
      const Real total = wa + wb + wc;
      return {{i, j, k}, {wa / total, wb / total, wc / total}, 3, (n.dot(a) / square) * n};
    }
    part best{{}, {}, 0, a};
    const auto offer = [&](const part& p) {
      if (best.size == 0 || p.nearest.squaredNorm() < best.nearest.squaredNorm()) best = p;
    };
    if (flat || !(wc > 0)) offer(on_segment(i, j));
    if (flat || !(wb > 0)) offer(on_segment(i, k));
    if (flat || !(wa > 0)) offer(on_segment(j, k));
    return best;
  }
  void reduce_tetrahedron(bool outside) {
    constexpr int faces[4][4] = {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}};
    part best{{}, {}, 0, vector::Zero()};
    for (const auto& f : faces) {
      const vector &a = points_[f[0]].w, &b = points_[f[1]].w, &c = points_[f[2]].w;
      const vector n = (b - a).cross(c - a);
      const Real inner = n.dot(points_[f[3]].w - a), here = -n.dot(a);
      // On the inner side of a face that is no sliver: not the nearest.
      if (!outside && here * inner > 0 && inner * inner > Real(1e-28) * n.squaredNorm()) continue;
      const part p = on_triangle(f[0], f[1], f[2]);
      if (best.size == 0 || p.nearest.squaredNorm() < best.nearest.squaredNorm()) best = p;
    }
    if (best.size > 0) keep(best);
  }

  difference_point<Real> points_[4];
  Real weights_[4];
  vector nearest_;
  int size_ = 0;
};

enum class separation { beyond, apart, touching };

/// Two cores apart: the distance along the unit normal from b to a, and the nearest points.
template <class Real>
struct core_distance {
  separation state = separation::touching;
  Real gap = 0;
  vector3<Real> normal{0, 0, 0}, on_a{0, 0, 0}, on_b{0, 0, 0};
  simplex<Real> corners;
  vector3<Real> shift{0, 0, 0};  ///< of a, when the corners were found
};

/// `beyond` if the distance is more than `limit`, `touching` if it is at most `least` (or the cores
/// overlap, or round-off hides on which side they are); the rest is set only where they are
/// `apart`. Begins with the corners of an answer to a similar question, or else with `guess`, any
/// direction. After 100 steps the gap is that along the best direction so far, by which the cores
/// are apart for certain, and they are `touching` if it is at most `least`.
template <class Real>
[[nodiscard]] core_distance<Real> distance_of(const convex_pair<Real>& pair,
                                              const vector3<Real>& guess, Real least, Real limit,
                                              const simplex<Real>& start = {}) {
  using vector = vector3<Real>;
  core_distance<Real> found;
  simplex<Real> s = start;
  vector v = s.size() > 0 ? s.nearest() : guess;
  if (!(v.squaredNorm() > 0)) v = {1, 0, 0};
  Real square = s.size() > 0 ? v.squaredNorm() : std::numeric_limits<Real>::infinity();
  bool outside = s.size() > 0;  // some direction separates the two
  Real along = 0;               // the distance along v, times its length
  int k = s.size();
  for (; k < 100; ++k) {
    const difference_point<Real> p = pair.support(-v);
    const Real length = v.norm();
    along = v.dot(p.w);
    if (along > limit * length) {
      found.state = separation::beyond;
      return found;
    }
    if (k > 0 && (square - along <= Real(1e-9) * square || s.contains(p.w))) break;
    simplex<Real> next = s;
    outside = outside || along > 0;
    next.add(p, outside);
    const vector nearer = next.nearest();
    const Real now = nearer.squaredNorm();
    if (next.size() == 4 || now <= least * least) return found;
    if (k > 0 && now >= square) break;
    s = next, v = nearer, square = now;
  }
  found.gap = std::sqrt(square);
  found.normal = v / found.gap;
  // The nearest point of a thin triangle is on its wrong side by round-off.
  if (k < 100 && along < Real(0.5) * square) return found;
  if (k == 100) found.gap = pair.gap_along(found.normal);
  if (!(found.gap > least)) return found;
  found.state = separation::apart;
  found.on_a = s.on_a();
  found.on_b = s.on_b();
  found.corners = s;
  return found;
}

}  // namespace talus::detail
