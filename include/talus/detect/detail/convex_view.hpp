#pragma once
// The view of a shape for the general convex routines: furthest points, flat faces and straight
// edges, in one type for all shapes, so that they are compiled once. It is made of the form of the
// shape (shape/convex_form.hpp). A capsule is a segment with a distance around it, its rounding.
// Everything in the convex_*.hpp files is a template of the scalar, so that worlds without such
// shapes do not compile it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/detect/detail/box_frame.hpp"
#include "talus/shape/convex_form.hpp"
#include "talus/shape/polyhedron_mesh.hpp"

namespace talus::detail {

/// Names a corner, an edge or a face of one shape; never 0.
using part_code = std::uint32_t;

/// The corners of a face in turn, or the two ends of a line. An edge runs from its corner to the
/// next one.
template <class Real>
struct outline {
  static constexpr int capacity = polyhedron_mesh::max_corners;
  struct corner {
    vector3<Real> at;
    part_code code, edge;
  };
  std::array<corner, capacity> corners;
  int size = 0;
  part_code face = 0;

  void add(const vector3<Real>& at, part_code code, part_code edge) {
    corners[static_cast<std::size_t>(size++)] = {at, code, edge};
  }
  [[nodiscard]] bool line() const { return size == 2; }
};

/// A posed shape; all coordinates and directions are those of the frame in which it is posed.
template <class Real>
class convex_view {
  using vector = vector3<Real>;

 public:
  convex_view(const block_form& f, const pose& at) : convex_view(kind::box, at) {
    half_ = f.half;
    inner_ = smallest_ = half_.minCoeff();
  }
  convex_view(const segment_form& f, const pose& at) : convex_view(kind::segment, at) {
    half_ = {0, 0, f.half};
    rounding_ = smallest_ = f.rounding;
  }
  convex_view(const drum_form& f, const pose& at) : convex_view(kind::cylinder, at) {
    half_ = {f.radius, f.radius, f.half};
    inner_ = smallest_ = half_.minCoeff();
  }
  convex_view(const mesh_form& f, const pose& at) : convex_view(kind::mesh, at) {
    mesh_ = f.mesh;
    rounding_ = f.rounding;
    smallest_ = mesh_->measured.half_width + rounding_;
    inner_ = mesh_->measured.inner_radius;
  }
  convex_view(const ball_form& f, const pose& at) : convex_view(kind::point, at) {
    rounding_ = smallest_ = f.radius;
  }
  convex_view(const smooth_form& f, const pose& at) : convex_view(kind::smooth, at) {
    smooth_ = f;
    smallest_ = f.thickness;
    inner_ = f.inner;
  }

  [[nodiscard]] const vector& centre() const { return centre_; }
  /// Distance of the surface from the core, to which all other functions refer.
  [[nodiscard]] Real rounding() const { return rounding_; }
  /// The approximate thickness of the shape, the scale of tolerances.
  [[nodiscard]] Real smallest() const { return smallest_; }
  [[nodiscard]] bool curved() const { return kind_ == kind::cylinder || smooth(); }
  [[nodiscard]] bool smooth() const { return kind_ == kind::smooth; }
  /// Whether it is known by its support function alone, which may have flat sides.
  [[nodiscard]] bool may_have_flat_sides() const { return smooth() && smooth_.flat > 0; }
  /// Whether the core has neither faces nor edges.
  [[nodiscard]] bool featureless() const { return smooth() || kind_ == kind::point; }

  /// A point of the core furthest along a direction.
  [[nodiscard]] vector support(const vector& direction) const {
    const vector d = axes_.transpose() * direction;
    return place(local_support(d));
  }

  [[nodiscard]] bool has_level() const { return smooth_.level != nullptr; }
  /// The function whose level is the surface of a smooth shape, with derivatives times `size`.
  [[nodiscard]] surface_level level(const vector& p, Real size) const {
    return turned(smooth_.level(smooth_.shape, local(p)), axes_, size);
  }

  /// The ends of the axis of a cylinder, first the one that is nearer to the point `p`, and its
  /// radius; false for other shapes.
  [[nodiscard]] bool round_axis(const vector& p, vector& from, vector& to, Real& radius) const {
    if (kind_ != kind::cylinder) return false;
    const Real near = axes_.col(2).dot(p - centre_) < 0 ? -half_[2] : half_[2];
    from = place({0, 0, near}), to = place({0, 0, -near}), radius = half_[0];
    return true;
  }

  /// The edge nearest to the point `p` of those that end at a corner furthest along `direction`;
  /// first the end that is nearer to the point. False for shapes without such edges.
  [[nodiscard]] bool edge_near(const vector& p, const vector& direction, vector& from,
                               vector& to) const {
    if (kind_ != kind::box && kind_ != kind::mesh) return false;
    const vector at = local(p), d = axes_.transpose() * direction;
    Real least = std::numeric_limits<Real>::infinity();
    const auto look_at = [&](const vector& a, const vector& b) {
      const vector ab = b - a;
      const Real t = std::clamp<Real>(ab.dot(at - a) / ab.squaredNorm(), Real(0), Real(1));
      const Real distance = (a + t * ab - at).squaredNorm();
      if (!(distance < least)) return;
      least = distance, from = a, to = b;
      if (t > Real(0.5)) std::swap(from, to);
    };
    const vector tip = local_support(d);
    if (kind_ == kind::box) {
      for (int i = 0; i < 3; ++i) {
        vector other = tip;
        other[i] = -other[i];
        look_at(tip, other);
      }
    } else {
      const auto corner = static_cast<std::uint32_t>(mesh_->furthest(d));
      for (const auto f : mesh_->faces_around(corner))
        for (const auto e : mesh_->edges_of_face(f)) {
          const auto& edge = mesh_->edges[e];
          if (edge.from == corner || edge.to == corner)
            look_at(mesh_->vertices[edge.from], mesh_->vertices[edge.to]);
        }
    }
    from = place(from), to = place(to);
    return true;
  }

  [[nodiscard]] int faces() const {
    switch (kind_) {
      case kind::box:
        return 6;
      case kind::cylinder:
        return 2;
      case kind::mesh:
        return static_cast<int>(mesh_->faces());
      default:
        break;
    }
    return 0;
  }
  /// Outward normal of a face.
  [[nodiscard]] vector normal(int face) const {
    if (kind_ == kind::mesh) return axes_ * mesh_->normals[static_cast<std::size_t>(face)];
    const int axis = kind_ == kind::box ? face / 2 : 2;
    return face & 1 ? vector(axes_.col(axis)) : vector(-axes_.col(axis));
  }
  /// A point in the frame of the body.
  [[nodiscard]] vector local(const vector& p) const { return axes_.transpose() * (p - centre_); }
  /// Distance of a point, in the frame of the body, beyond the plane of a face.
  [[nodiscard]] Real beyond(int face, const vector& local) const {
    if (kind_ == kind::mesh)
      return mesh_->normals[static_cast<std::size_t>(face)].dot(local) - offset(face);
    const int axis = kind_ == kind::box ? face / 2 : 2;
    return (face & 1 ? local[axis] : -local[axis]) - half_[axis];
  }
  /// Radius of a ball around the centre inside the core.
  [[nodiscard]] Real inner_radius() const { return inner_; }
  /// Smallest radius of curvature of a smooth core, about.
  [[nodiscard]] Real sharpest() const { return smooth() ? smooth_.sharpest : Real(0); }
  /// Distance of a face's plane from the centre.
  [[nodiscard]] Real offset(int face) const {
    if (kind_ == kind::mesh) return mesh_->offsets[static_cast<std::size_t>(face)];
    return half_[kind_ == kind::box ? face / 2 : 2];
  }

  /// The corners of a face; those of a circle are some of its points.
  void face_outline(int face, outline<Real>& out) const {
    switch (kind_) {
      case kind::box:
        return box_face(face / 2, face & 1, out);
      case kind::cylinder:
        return cap(face & 1, vector(0, 0, 0), 16, out);
      case kind::mesh:
        return mesh_face(static_cast<std::size_t>(face), out);
      default:
        break;
    }
  }
  /// The face, or the line, that faces a direction most; it holds a point furthest along it. Of a
  /// circle, `rim` corners are taken, a multiple of four and at most 16.
  void outline_along(const vector& direction, int rim, outline<Real>& out) const {
    const vector d = axes_.transpose() * direction;
    switch (kind_) {
      case kind::box: {
        int axis = 0;
        if (std::abs(d[1]) > std::abs(d[axis])) axis = 1;
        if (std::abs(d[2]) > std::abs(d[axis])) axis = 2;
        return box_face(axis, d[axis] > 0, out);
      }
      case kind::segment:
        out.size = 0;
        out.face = 3;
        out.add(place({0, 0, -half_[2]}), 1, 3);
        out.add(place({0, 0, half_[2]}), 2, 3);
        return;
      case kind::cylinder: {
        if (2 * d[2] * d[2] >= d.squaredNorm()) return cap(d[2] > 0, d, rim, out);
        out.size = 0;
        out.face = 3;
        for (const bool top : {false, true}) {
          const vector p = local_support({d[0], d[1], top ? Real(1) : Real(-1)});
          out.add(place(p), 4u + top, 3);
        }
        return;
      }
      case kind::mesh: {
        std::uint32_t best = 0;
        Real most = -std::numeric_limits<Real>::infinity();
        for (const auto f : mesh_->faces_around(mesh_->furthest(d))) {
          const Real looks = mesh_->normals[f].dot(d);
          if (looks > most) most = looks, best = f;
        }
        return mesh_face(best, out);
      }
      case kind::smooth:
        if (smooth_.flat > 0 && flat_side(d, out)) return;
        [[fallthrough]];
      case kind::point:
        out.size = 0;
        out.face = 1;
        out.add(place(local_support(d)), 1, 1);
        return;
    }
  }

  /// The straight line on the surface that touches a plane across `direction` (unit), nearly: an
  /// edge, a segment, a line on a cylinder. Of several edges, the one most along `favoured`.
  [[nodiscard]] bool line_along(const vector& direction, const vector& favoured,
                                outline<Real>& out) const {
    constexpr Real level = Real(0.05);
    if (featureless()) return false;
    const vector d = axes_.transpose() * direction, want = axes_.transpose() * favoured;
    if (kind_ == kind::segment || kind_ == kind::cylinder) {
      if (std::abs(d[2]) > level) return false;
      outline_along(direction, 4, out);
      return true;
    }
    Real most = 0;
    vector from, to;
    part_code code = 0, ends[2] = {0, 0};
    if (kind_ == kind::box) {
      const vector tip = local_support(d);
      for (int i = 0; i < 3; ++i) {
        if (std::abs(d[i]) > level || !(std::abs(want[i]) > most)) continue;
        const int u = (i + 1) % 3, v = (i + 2) % 3;
        most = std::abs(want[i]);
        from = to = tip;
        from[i] = -half_[i], to[i] = half_[i];
        code = side(u, tip[u] > 0) | side(v, tip[v] > 0);
        ends[0] = code | side(i, false), ends[1] = code | side(i, true);
      }
    } else {
      const auto tip = static_cast<std::uint32_t>(mesh_->furthest(d));
      for (const auto f : mesh_->faces_around(tip))
        for (const auto e : mesh_->edges_of_face(f)) {
          const auto& edge = mesh_->edges[e];
          if (edge.from != tip && edge.to != tip) continue;
          const vector a = mesh_->vertices[edge.from], b = mesh_->vertices[edge.to];
          const vector along = (b - a).normalized();
          const Real fit = std::abs(along.dot(want));
          if (std::abs(along.dot(d)) > level || !(fit > most)) continue;
          most = fit, from = a, to = b;
          ends[0] = corner_code(edge.from), ends[1] = corner_code(edge.to), code = edge_code(e);
        }
    }
    if (code == 0) return false;
    out.size = 0;
    out.face = code;
    out.add(place(from), ends[0], code);
    out.add(place(to), ends[1], code);
    return true;
  }

 private:
  enum class kind : std::uint8_t { segment, box, cylinder, mesh, point, smooth };

  convex_view(kind k, const pose& at)
      : kind_(k), centre_(at.position), axes_(at.orientation.toRotationMatrix()) {}

  [[nodiscard]] vector place(const vector& local) const { return centre_ + axes_ * local; }
  [[nodiscard]] vector local_support(const vector& d) const {
    if (smooth()) return smooth_.support(smooth_.shape, d);
    if (kind_ == kind::point) return {0, 0, 0};
    if (kind_ == kind::mesh) return mesh_->vertices[mesh_->furthest(d)];
    vector p{d[0] < 0 ? -half_[0] : half_[0], d[1] < 0 ? -half_[1] : half_[1],
             d[2] < 0 ? -half_[2] : half_[2]};
    if (kind_ == kind::cylinder) {
      const Real largest = std::max(std::abs(d[0]), std::abs(d[1]));
      const Real x = largest > 0 ? d[0] / largest : 1, y = largest > 0 ? d[1] / largest : 0;
      const Real scale = half_[0] / std::sqrt(x * x + y * y);
      p[0] = scale * x, p[1] = scale * y;
    }
    return p;
  }

  void box_face(int axis, bool positive, outline<Real>& out) const {
    const int n = (axis + 1) % 3, o = (axis + 2) % 3;
    constexpr bool around[4][2] = {{false, false}, {true, false}, {true, true}, {false, true}};
    out.size = 0;
    out.face = side(axis, positive);
    for (int k = 0; k < 4; ++k) {
      const auto &here = around[positive ? k : 3 - k],
                 &next = around[positive ? (k + 1) % 4 : (6 - k) % 4];
      const auto corner = [&](const bool* at) {
        return out.face | side(n, at[0]) | side(o, at[1]);
      };
      vector p;
      p[axis] = positive ? half_[axis] : -half_[axis];
      p[n] = here[0] ? half_[n] : -half_[n];
      p[o] = here[1] ? half_[o] : -half_[o];
      out.add(place(p), corner(here), corner(here) & corner(next));
    }
  }

  [[nodiscard]] static part_code corner_code(std::uint32_t vertex) { return 1 + vertex; }
  [[nodiscard]] part_code edge_code(std::uint32_t e) const {
    return 1 + static_cast<part_code>(mesh_->vertices.size()) + e;
  }
  void mesh_face(std::size_t f, outline<Real>& out) const {
    const auto corners = mesh_->face(f);
    const auto edges = mesh_->edges_of_face(f);
    out.size = 0;
    out.face = edge_code(static_cast<std::uint32_t>(mesh_->edges.size() + f));
    for (std::size_t k = 0; k < corners.size(); ++k)
      out.add(place(mesh_->vertices[corners[k]]), corner_code(corners[k]), edge_code(edges[k]));
  }

  /// The outline of a side that is flat and faces `d`, or a straight line of the surface, by the
  /// points furthest along up to 16 directions around it; false if there is none.
  [[nodiscard]] bool flat_side(const vector& d, outline<Real>& out) const {
    const vector n = d.normalized();
    // The first axis that makes an angle of more than 49.5 degrees with the normal: no usual normal
    // lies near that limit, so that a small turn leaves the directions around it as they are.
    int axis = 0;
    while (std::abs(n[axis]) > Real(0.65)) ++axis;
    const vector v = n.cross(vector(vector::Unit(axis))).normalized(), u = v.cross(n);
    constexpr Real cos[5] = {1, Real(0.92387953251128674), Real(0.70710678118654752),
                             Real(0.38268343236508977), 0};
    const auto cosine = [&](int k) {
      k &= 15;
      return k <= 4 ? cos[k] : k <= 12 ? -cos[k <= 8 ? 8 - k : k - 8] : cos[16 - k];
    };
    const auto furthest = [&](int k) {
      return local_support(n + Real(1e-3) * vector(cosine(k) * u + cosine(k + 12) * v));
    };
    const Real apart = smooth_.flat;
    if (!((furthest(0) - furthest(8)).norm() > apart) &&
        !((furthest(4) - furthest(12)).norm() > apart))
      return false;
    struct corner {
      vector at;
      Real x, y;
      int order;
    };
    std::array<corner, 16> all;
    int size = 0;
    // Points of a side that leans come twice, on the way there and back.
    const auto add = [&](int k) {
      const vector p = furthest(k);
      for (int i = 0; i < size; ++i)
        if ((p - all[index(i)].at).norm() < Real(0.1) * apart) return;
      all[index(size++)] = {p, u.dot(p), v.dot(p), k};
    };
    for (int k = 0; k < 16; ++k) add(k);
    // Sides that lean by up to 1e-3 have a corner within 2e-5 of their size of the furthest point,
    // and a curved surface with points so far apart does not.
    Real reach = n.dot(all[0].at);
    for (int i = 1; i < size; ++i) reach = std::max(reach, n.dot(all[index(i)].at));
    if (n.dot(local_support(n)) - reach > Real(2.2e-4) * apart) return false;
    Real x = 0, y = 0;
    for (int i = 0; i < size; ++i) x += all[index(i)].x / size, y += all[index(i)].y / size;
    const auto turn = [&](const corner& c) {
      const Real a = c.x - x, b = c.y - y, sum = std::abs(a) + std::abs(b);
      if (!(sum > 0)) return Real(0);
      return b < 0 ? a / sum - 2 : -a / sum;  // rises with the angle, without functions of it
    };
    std::sort(all.begin(), all.begin() + size, [&](const corner& a, const corner& b) {
      const Real of_a = turn(a), of_b = turn(b);
      return of_a < of_b || (of_a == of_b && a.order < b.order);
    });
    std::rotate(all.begin(),
                std::min_element(all.begin(), all.begin() + size,
                                 [](const auto& a, const auto& b) { return a.order < b.order; }),
                all.begin() + size);
    out.size = 0;
    out.face = 1;
    for (int i = 0; i < size; ++i) {
      const auto number = static_cast<part_code>(all[index(i)].order);
      out.add(place(all[index(i)].at), 2 + number, 32 + number);
    }
    return true;
  }
  [[nodiscard]] static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  /// Points of the edge circle of a flat face of a cylinder. They begin at its furthest point along
  /// `d`, or, if the face is level within 2e-3, at a fixed point, so that a standing cylinder keeps
  /// its contact points. (Of 16 fixed points the furthest is then short of that point by 4e-5 of
  /// the radius at most.)
  void cap(bool top, const vector& d, int rim, outline<Real>& out) const {
    const Real tilt = portable::hypot(d[0], d[1]);
    const bool level = !(tilt > Real(2e-3) * std::abs(d[2]));
    Real x = level ? 1 : d[0] / tilt, y = level ? 0 : d[1] / tilt;
    const Real c = rim == 4 ? 0 : rim == 8 ? std::sqrt(Real(0.5)) : Real(0.92387953251128674);
    const Real s = (top ? 1 : -1) * std::sqrt(1 - c * c);
    const part_code base = 32u * (1 + top) + 64u * !level;
    out.size = 0;
    out.face = 6u + top;
    for (int k = 0; k < rim; ++k) {
      const auto number = static_cast<part_code>(k * (16 / rim));
      out.add(place({half_[0] * x, half_[0] * y, top ? half_[2] : -half_[2]}), base + number,
              base + 16 + number);
      const Real turned = c * x - s * y;
      y = s * x + c * y;
      x = turned;
    }
  }

  kind kind_;
  vector centre_;
  matrix3<Real> axes_;
  vector half_{0, 0, 0};
  const polyhedron_mesh* mesh_ = nullptr;
  smooth_form smooth_;
  Real rounding_ = 0, smallest_ = 0, inner_ = 0;
};

}  // namespace talus::detail
