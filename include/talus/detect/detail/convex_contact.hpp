#pragma once
// Contacts of two convex shapes: a manifold over a flat face if one is suitable, which is nearly
// always so for resting bodies; else along two parallel lines, or a single point.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/detail/convex_climb.hpp"
#include "talus/detect/detail/convex_depth.hpp"
#include "talus/detect/detail/convex_distance.hpp"
#include "talus/detect/detail/convex_patch.hpp"

namespace talus::detail {

template <class Real>
class convex_contact {
  using vector = vector3<Real>;

 public:
  /// Both shapes posed in one frame, whose origin is at `origin` in the world and whose axes are
  /// those of the world. Contacts of `piecewise` shapes are parts of those of a larger face, so
  /// that small corners of their manifolds count.
  convex_contact(const convex_view<Real>& a, const convex_view<Real>& b, const vec3& origin,
                 Real margin, bool piecewise = false)
      : a_(a),
        b_(b),
        origin_(origin),
        margin_(margin),
        rounding_(a.rounding() + b.rounding()),
        smallest_(std::min(a.smallest(), b.smallest())),
        strip_(piecewise || rounding_ > 0 ? Real(0) : flush_strip<Real> * smallest_),
        least_corner_(piecewise ? Real(1e-9) : Real(1e-4)) {}

  /// The points with a gap of at most the margin, at most 16. (A list, so that this is compiled
  /// once for all uses of the points.) Without `climb` the pair has been refused by a function of
  /// its own that begins with the normal, as two smooth bodies do here.
  [[nodiscard]] std::span<const contact_geometry> find(bool climb = true) {
    size_ = 0;
    search(climb);
    return {found_.data(), size_};
  }
  /// The points over that face of a, along its normal: for a face that other faces continue, where
  /// a direction beside the normal is slightly nearer and belongs to none of them.
  [[nodiscard]] std::span<const contact_geometry> over_face(int face) {
    size_ = 0;
    const vector up = a_.normal(face);
    const Real gap = up.dot(b_.support(-up) - a_.centre()) - a_.offset(face) - rounding_;
    if (gap <= margin_) by_face({face, gap}, false, std::numeric_limits<Real>::infinity());
    return {found_.data(), size_};
  }

 private:
  static constexpr Real level_ = Real(0.005);

  void search(bool climb) {
    const face_axis of_a = best_face(a_, b_), of_b = best_face(b_, a_);
    if (of_a.gap > margin_ || of_b.gap > margin_) return;
    const bool by_b = of_a.face < 0 || of_b.gap > of_a.gap + tolerance(of_a.gap);
    const face_axis& face = by_b ? of_b : of_a;
    // For shapes that touch, or nearly, a face with points as near as its plane allows is correct,
    // because no other direction is better by more than the tolerance.
    if (face.gap >= -level_ * smallest_ && by_face(face, by_b, face.gap)) return;

    const convex_pair<Real> pair{a_, b_};
    if (climb && a_.featureless() && b_.featureless() && by_climbing(pair)) return;
    core_distance<Real> nearest = distance_of<Real>(pair, a_.centre() - b_.centre(),
                                                    Real(1e-6) * smallest_, margin_ + rounding_);
    if (nearest.state == separation::beyond) return;
    if (nearest.state == separation::touching) {
      nearest = depth_of<Real>(pair, smallest_);
      const Real gap = nearest.gap - rounding_;
      if (gap > margin_) return;
      if (face.gap >= gap - tolerance(gap) && by_face(face, by_b, gap)) return;
    } else if (rounding_ > 0 && face.gap < -level_ * smallest_) {
      // Rounded shapes that overlap, though their cores do not.
      const Real gap = nearest.gap - rounding_;
      if (face.gap >= gap - tolerance(gap) && by_face(face, by_b, gap)) return;
    }
    if (a_.smooth() || b_.smooth()) sharpen<Real>(pair, nearest, size());
    const Real gap = nearest.gap - rounding_;
    if (gap > margin_ || by_lines(nearest, gap) || by_flat_sides(nearest.normal, gap)) return;
    single(nearest.normal, nearest.on_a, nearest.on_b, gap);
  }

  /// Length that rounding errors of positions are proportional to.
  [[nodiscard]] Real size() const {
    return (a_.centre() - b_.centre()).norm() + smallest_ + rounding_;
  }
  /// Two bodies without faces and edges, unless they overlap deeply. The gap along a normal has one
  /// maximum as long as the depth is below the sum of the smallest radii of curvature: the
  /// difference of the bodies is then that sum around a convex body without the origin.
  [[nodiscard]] bool by_climbing(const convex_pair<Real>& pair) {
    const vector between = a_.centre() - b_.centre();
    if (!(between.squaredNorm() > 0)) return false;
    const held_pair<Real> search{pair, held_part<Real>{}, held_part<Real>{}};
    const summit_of<Real> s =
        climb<Real>(search, between, vector::Zero(), margin_ + rounding_, size());
    if (s.state == climbed::beyond) return true;
    const Real unique = Real(0.5) * (a_.sharpest() + b_.sharpest());
    if (s.state == climbed::lost || s.gap < -std::min(Real(0.1) * smallest_, unique)) return false;
    if (by_flat_sides(s.normal, s.gap - rounding_)) return true;
    single(s.normal, s.at.a, s.at.b, s.gap - rounding_);
    return true;
  }
  /// One contact, of points on the cores.
  void single(const vector& normal, const vector& core_a, const vector& core_b, Real gap) {
    const vector on_a = core_a - a_.rounding() * normal, on_b = core_b + b_.rounding() * normal;
    emit(normal, Real(0.5) * (on_a + on_b), gap, 0, 0);
  }

  /// The face that separates the shapes best, and the gap of the surfaces along its normal.
  struct face_axis {
    int face = -1;
    Real gap = -std::numeric_limits<Real>::infinity();
  };
  [[nodiscard]] face_axis best_face(const convex_view<Real>& one,
                                    const convex_view<Real>& other) const {
    // The ball inside the other shape gives a bound for each face. Test the best bounds first, and
    // only faces that can still be better.
    const int faces = one.faces();
    const vector centre = one.local(other.centre());
    face_axis best, first;
    const auto bound = [&](int f) {
      return one.beyond(f, centre) - other.inner_radius() - rounding_;
    };
    for (int f = 0; f < faces; ++f)
      if (const Real most = bound(f); most > first.gap) first = {f, most};
    const auto look_at = [&](int f) {
      const vector normal = one.normal(f);
      const Real gap =
          normal.dot(other.support(-normal) - one.centre()) - one.offset(f) - rounding_;
      if (gap > best.gap || (gap == best.gap && f < best.face)) best = {f, gap};
    };
    if (first.face >= 0) look_at(first.face);
    for (int f = 0; f < faces && best.gap <= margin_; ++f)
      if (f != first.face && bound(f) >= best.gap) look_at(f);
    return best;
  }
  /// By how much one direction must be better than another to be preferred to it.
  [[nodiscard]] Real tolerance(Real gap) const {
    return level_ * smallest_ + Real(0.05) * std::abs(gap);
  }

  void emit(const vector& normal, const vector& point, Real gap, part_code of_a, part_code of_b) {
    found_[size_++] = {normal, origin_ + point, gap, of_a | of_b << 16};
  }

  /// The manifold over that face, if it holds points with a gap near `wanted`, the smallest gap.
  bool by_face(const face_axis& face, bool by_b, Real wanted) {
    if (face.face < 0) return false;
    const convex_view<Real>& one = by_b ? b_ : a_;
    outline<Real> reference;
    one.face_outline(face.face, reference);
    return by_outline(reference, one.normal(face.face), by_b, wanted);
  }
  /// The manifold over a flat side of a shape that is known by its support function alone, if that
  /// side faces the other shape along `normal`.
  bool by_flat_sides(const vector& normal, Real wanted) {
    for (const bool by_b : {false, true}) {
      const convex_view<Real>& one = by_b ? b_ : a_;
      const vector up = by_b ? normal : vector(-normal);
      outline<Real> side;
      if (!one.may_have_flat_sides()) continue;
      one.outline_along(up, most_corners, side);
      if (side.size < 3) continue;
      const vector across = normal_of(side);
      if (across.dot(up) > 1 - Real(2e-6) && by_outline(side, across, by_b, wanted)) return true;
    }
    return false;
  }
  /// By the sum of the areas of its triangles.
  [[nodiscard]] static vector normal_of(const outline<Real>& side) {
    vector sum(0, 0, 0);
    const vector& first = side.corners[0].at;
    for (std::size_t k = 2; k < static_cast<std::size_t>(side.size); ++k)
      sum += (side.corners[k - 1].at - first).cross(side.corners[k].at - first);
    return sum.normalized();
  }
  /// How far beyond an outline a corner of this one counts as inside. A round side a little beyond
  /// an edge overlaps the body below anyway, and rests on it until the next body carries it.
  [[nodiscard]] Real slack_of(const convex_view<Real>& other, const outline<Real>& incident) const {
    const bool on_line = other.curved() && incident.size == 2;
    if (on_line || (other.rounding() > 0 && incident.size <= 2)) return Real(1e-3) * smallest_;
    return other.smooth() && incident.size == 1 ? Real(0) : outline_slack<Real> * smallest_;
  }
  bool by_outline(const outline<Real>& reference, const vector& up, bool by_b, Real wanted) {
    const convex_view<Real>& other = by_b ? a_ : b_;
    outline<Real> incident;
    other.outline_along(-up, most_corners, incident);
    const Real near = Real(1e-3) * smallest_;
    const auto over_outline = [&](Real slack) {
      return convex_patch<Real>(reference, up, incident, slack, near);
    };
    const convex_patch<Real> patch = over_outline(slack_of(other, incident));
    if (patch.empty() && std::abs(wanted) <= strip_ && over_outline(strip_).is_strip(strip_))
      return true;
    const bool apart = wanted > Real(1e-6) * smallest_;
    const Real enough =
        wanted + (apart ? Real(0.05) * wanted + Real(1e-4) * smallest_ : tolerance(wanted));
    if (!(patch.lowest() - rounding_ <= std::min(enough, margin_))) return false;
    if (strip_ > 0 && patch.is_strip(strip_)) return true;
    const vector normal = by_b ? up : vector(-up);
    const Real tolerance = Real(1e-4) * smallest_;
    patch.for_each(margin_ + rounding_, tolerance, least_corner_, [&](const patch_point<Real>& p) {
      const Real gap = p.height - rounding_;
      const vector point = p.at - (other.rounding() + Real(0.5) * gap) * up;
      emit(normal, point, gap, by_b ? p.incident : p.reference, by_b ? p.reference : p.incident);
    });
    return true;
  }

  /// Two contacts if a straight line of each shape lies along the other.
  bool by_lines(const core_distance<Real>& nearest, Real gap) {
    const vector& n = nearest.normal;
    outline<Real> of_a, of_b;
    if (!a_.line_along(-n, b_line(n), of_a)) return false;
    const vector p = of_a.corners[0].at, pq = of_a.corners[1].at - p;
    const Real length = pq.norm();
    const vector u = pq / length;
    if (!b_.line_along(n, u, of_b)) return false;
    const vector r = of_b.corners[0].at, rs = of_b.corners[1].at - r, v = rs.normalized();
    const Real same = u.dot(v);
    if (!(std::abs(same) > Real(0.995))) return false;
    const Real from = u.dot(r - p), to = from + u.dot(rs);
    const bool turned = to < from;
    const Real low = std::max(Real(0), turned ? to : from),
               high = std::min(length, turned ? from : to);
    if (!(high - low > Real(1e-2) * smallest_)) return false;
    struct place {
      vector point;
      Real gap;
      part_code a, b;
    } ends[2];
    Real least = std::numeric_limits<Real>::infinity();
    for (const bool far : {false, true}) {
      const Real s = far ? high : low;
      const vector on_a = p + s * u, on_b = r + ((s - from) / same) * v, across = on_a - on_b;
      place& end = ends[far];
      end.gap = n.dot(across) - rounding_;
      if ((across - n.dot(across) * n).norm() > Real(0.02) * smallest_) return false;
      end.point = Real(0.5) * (on_a + on_b + (b_.rounding() - a_.rounding()) * n);
      const bool at_a = far ? s == length : s == 0;
      end.a = at_a ? of_a.corners[far].code : of_a.face;
      end.b = at_a ? of_b.face : of_b.corners[far != turned].code;
      least = std::min(least, end.gap);
    }
    if (!(least <= gap + Real(0.05) * std::abs(gap) + Real(1e-4) * smallest_)) return false;
    for (const place& end : ends)
      if (end.gap <= margin_) emit(n, end.point, end.gap, end.a, end.b);
    return true;
  }
  /// Direction of the line of b that may touch, or zero.
  [[nodiscard]] vector b_line(const vector& n) const {
    outline<Real> line;
    const vector any = n.cross(vector::Unit(std::abs(n[0]) < Real(0.6) ? 0 : 1));
    if (b_.faces() > 2 || !b_.line_along(n, any, line)) return any;
    return line.corners[1].at - line.corners[0].at;
  }

  const convex_view<Real>&a_, &b_;
  vec3 origin_;
  Real margin_, rounding_, smallest_;
  Real strip_;         ///< a manifold narrower than this carries nothing; 0 if all may carry
  Real least_corner_;  ///< see keep_outline()
  std::array<contact_geometry, most_corners> found_;
  std::size_t size_ = 0;
};

}  // namespace talus::detail
