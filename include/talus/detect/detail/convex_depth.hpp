#pragma once
// The penetration depth of two convex cores and its direction: the expanding polytope algorithm
// (van den Bergen 2001) on the Minkowski difference of the two. It starts from any tetrahedron in
// the difference; a face with the origin beyond it is the nearest one.
#include <array>
#include <cmath>
#include <limits>

#include "talus/detect/detail/convex_distance.hpp"

namespace talus::detail {

template <class Real>
class expanding_polytope {
  using vector = vector3<Real>;

 public:
  explicit expanding_polytope(const convex_pair<Real>& pair) : pair_(pair) { start(); }

  using point = difference_point<Real>;

  /// A face of the polytope: its outward normal and its corners.
  struct facet {
    vector normal;
    point corners[3];
  };
  /// Grows the polytope until its face nearest to the origin is one of the difference, within
  /// `tolerance`, and returns it.
  [[nodiscard]] facet nearest(Real tolerance) {
    int best = nearest_face();
    facet found = facet_of(best);
    while (points_count_ < max_points) {
      const point p = pair_.support(found.normal);
      if (found.normal.dot(p.w) - face_at(best).offset <= tolerance || !insert(p, best)) break;
      best = nearest_face();
      found = facet_of(best);
    }
    return found;
  }

 private:
  static constexpr int max_points = 80, max_faces = 500;
  /// Edge k runs from corner k to the next; there it meets edge `edge[k]` of face `across[k]`.
  struct face {
    int corner[3], across[3], edge[3];
    bool gone;
    vector normal;  // outwards; zero for a sliver
    Real offset;    // of the plane from the origin, below zero if the origin is outside
  };
  struct border_edge {
    int face, edge;
  };

  [[nodiscard]] face& face_at(int i) { return faces_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] point& point_at(int i) { return points_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] facet facet_of(int i) {
    const face& f = face_at(i);
    return {f.normal, {point_at(f.corner[0]), point_at(f.corner[1]), point_at(f.corner[2])}};
  }

  void start() {
    // Furthest points along the axes; of these, two far apart.
    point low[3], high[3];
    int widest = 0;
    for (int i = 0; i < 3; ++i) {
      low[i] = pair_.support(-vector::Unit(i));
      high[i] = pair_.support(vector::Unit(i));
      if (high[i].w[i] - low[i].w[i] > high[widest].w[widest] - low[widest].w[widest]) widest = i;
    }
    const point a = low[widest], b = high[widest];
    const vector line = (b.w - a.w).normalized();
    // A third one far from their line, and a fourth one far from their plane.
    const vector u = line.cross(vector::Unit((widest + 1) % 3)).normalized(), v = line.cross(u);
    point c = a;
    Real furthest = -1;
    for (const vector& d : {u, vector(-u), v, vector(-v)}) {
      const point p = pair_.support(d);
      const Real away = (p.w - a.w).cross(line).squaredNorm();
      if (away > furthest) furthest = away, c = p;
    }
    const vector normal = (b.w - a.w).cross(c.w - a.w).normalized();
    const point above = pair_.support(normal), below = pair_.support(-normal);
    const bool up = normal.dot(above.w - a.w) > normal.dot(a.w - below.w);
    points_[0] = a;
    points_[1] = up ? c : b;
    points_[2] = up ? b : c;
    points_[3] = up ? above : below;
    points_count_ = 4;
    add_face(0, 1, 2), add_face(0, 3, 1), add_face(1, 3, 2), add_face(2, 3, 0);
    link(0, 0, 1, 2), link(0, 1, 2, 2), link(0, 2, 3, 2);
    link(1, 1, 2, 0), link(2, 1, 3, 0), link(3, 1, 1, 0);
  }

  void link(int f, int k, int g, int m) {
    face_at(f).across[k] = g, face_at(f).edge[k] = m;
    face_at(g).across[m] = f, face_at(g).edge[m] = k;
  }
  void add_face(int i, int j, int k) {
    face f{{i, j, k}, {}, {}, false, vector::Zero(), std::numeric_limits<Real>::infinity()};
    const vector &a = point_at(i).w, &b = point_at(j).w, &c = point_at(k).w;
    const vector area = (b - a).cross(c - a);
    const Real size = area.norm();
    // A sliver has no normal: it closes the surface, but is never tested.
    if (size > Real(1e-14) * ((b - a).squaredNorm() + (c - a).squaredNorm())) {
      f.normal = area / size;
      f.offset = f.normal.dot(a);
    }
    face_at(faces_count_++) = f;
  }
  [[nodiscard]] int nearest_face() {
    int best = -1;
    for (int f = 0; f < faces_count_; ++f)
      if (!face_at(f).gone && (best < 0 || face_at(f).offset < face_at(best).offset)) best = f;
    return best;
  }

  /// Adds a point beyond a face: removes all faces visible from the point, and joins their border
  /// to it. Returns false if there is no room, or if round-off has broken the border.
  bool insert(const point& p, int seen) {
    border_.size = 0;
    face_at(seen).gone = true;
    for (int k = 0; k < 3; ++k) look(p.w, face_at(seen).across[k], face_at(seen).edge[k]);
    const int first = faces_count_, size = border_.size, number = points_count_;
    if (size < 3 || size > max_border || first + size > max_faces) return false;
    point_at(points_count_++) = p;
    for (int k = 0; k < size; ++k) {
      const border_edge &e = border_.at[static_cast<std::size_t>(k)],
                        &next = border_.at[static_cast<std::size_t>(k + 1 < size ? k + 1 : 0)];
      const int from = face_at(e.face).corner[(e.edge + 1) % 3],
                to = face_at(e.face).corner[e.edge];
      if (face_at(next.face).corner[(next.edge + 1) % 3] != to) return false;
      add_face(from, to, number);
      link(first + k, 0, e.face, e.edge);
    }
    for (int k = 0; k < size; ++k) link(first + k, 1, first + (k + 1) % size, 2);
    return true;
  }
  /// Goes on to face f across its edge k.
  void look(const vector& p, int f, int k) {
    face& here = face_at(f);
    if (here.gone) return;
    const bool sliver = here.offset == std::numeric_limits<Real>::infinity();
    if (!sliver && !(here.normal.dot(p) > here.offset)) {
      if (border_.size < max_border) border_.at[static_cast<std::size_t>(border_.size)] = {f, k};
      ++border_.size;
      return;
    }
    here.gone = true;
    for (int m = 1; m < 3; ++m) look(p, here.across[(k + m) % 3], here.edge[(k + m) % 3]);
  }

  static constexpr int max_border = 64;
  const convex_pair<Real>& pair_;
  std::array<point, max_points> points_;
  std::array<face, max_faces> faces_;
  int points_count_ = 0, faces_count_ = 0;
  struct {
    std::array<border_edge, max_border> at;
    int size = 0;
  } border_;
};

/// Overlap (or touch) of two cores of which at least one has a volume. `smallest` is their
/// thickness, the scale of tolerances.
template <class Real>
[[nodiscard]] core_distance<Real> depth_of(const convex_pair<Real>& pair, Real smallest) {
  using vector = vector3<Real>;
  const bool curved = pair.a.curved() || pair.b.curved();
  expanding_polytope<Real> polytope(pair);
  auto facet = polytope.nearest(Real(curved ? 1e-3 : 1e-10) * smallest);
  // (The facets solve the cases in which the iteration below would be slow.)
  if (curved && pair.gap_along(-facet.normal) < Real(-0.1) * smallest)
    facet = polytope.nearest(Real(1e-6) * smallest);
  core_distance<Real> best;
  best.normal = -facet.normal;
  best.gap = pair.gap_along(best.normal);
  best.on_a = facet.corners[0].a, best.on_b = facet.corners[0].b;
  simplex<Real> corners;
  for (const auto& p : facet.corners) corners.add(p, true);
  best.corners = corners;
  vector moved = vector::Zero();
  // If one core is shifted slightly outside along the right direction, the nearest points are those
  // of deepest penetration. The normals of the facets of a round surface only approximate this
  // direction, but the direction of the nearest points is a better one: a fixed-point iteration
  // that converges by a factor of about depth over radius of curvature.
  for (int k = 0; k < (curved ? 6 : 1); ++k) {
    const vector out = (std::max(Real(0), -best.gap) + Real(0.01) * smallest) * best.normal;
    const auto apart =
        distance_of<Real>({pair.a, pair.b, pair.shift + out}, best.normal, 0,
                          std::numeric_limits<Real>::infinity(), corners.moved(out - moved));
    if (apart.state != separation::apart) break;
    const Real turned = (apart.normal - best.normal).squaredNorm();
    const Real gap = pair.gap_along(apart.normal);
    if (gap < best.gap - Real(1e-4) * smallest) break;
    best.on_a = apart.on_a - out;
    best.on_b = apart.on_b;
    best.corners = apart.corners, best.shift = out;
    if (!(gap > best.gap)) break;
    best.gap = gap;
    best.normal = apart.normal;
    if (turned < Real(1e-10)) break;
    corners = apart.corners;
    moved = out;
  }
  return best;
}

}  // namespace talus::detail
