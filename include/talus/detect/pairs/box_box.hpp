#pragma once
// Two boxes: a manifold of four contacts, or up to eight, if a face is involved, else a single one.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "talus/contact/contact_geometry.hpp"
#include "talus/detect/box_batch.hpp"
#include "talus/detect/box_place.hpp"
#include "talus/detect/detail/box_axes.hpp"
#include "talus/detect/detail/box_manifold.hpp"
#include "talus/detect/detail/box_nearest.hpp"
#include "talus/shape/box.hpp"

namespace talus {

namespace detail {

/// Whether the face of b that faces the reference face of a lies in its plane or over it, and the
/// two overlap in a strip narrower than flush_strip: an edge of one box lies along an edge of the
/// other, or will pass it.
template <class Real>
[[nodiscard]] bool is_strip(const box_pair<Real>& pair, int axis, bool face_of_b,
                            std::span<const box_contact<Real>> found) {
  const Real width = flush_strip<Real> * pair.smallest();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Real most[2] = {0, 0};
  for (const box_contact<Real>& c : found) {
    if (!(c.gap >= -width)) return false;
    most[0] = std::max(most[0], std::abs(c.point[u] - found[0].point[u]));
    most[1] = std::max(most[1], std::abs(c.point[v] - found[0].point[v]));
  }
  if (!(std::min(most[0], most[1]) <= width)) return false;
  Real tilt[3];  // rise over the plane along each half edge of the other box
  for (int k = 0; k < 3; ++k)
    tilt[k] =
        std::abs(face_of_b ? pair.axes(k, axis) * pair.ha[k] : pair.axes(axis, k) * pair.hb[k]);
  return 2 * (tilt[0] + tilt[1] + tilt[2] - std::max({tilt[0], tilt[1], tilt[2]})) <= width;
}

/// Calls `sink(contact_geometry)` for the corners of a patch, which are in the frame of its
/// reference box: of b's face (`face_of_b`), or a's, that looks along its axis `axis` or against.
template <class Sink, class Real>
void give_patch(const box_place<Real>& a, const box_place<Real>& b, const box_pair<Real>& pair,
                int axis, bool positive, bool face_of_b, std::span<box_contact<Real>> found,
                Sink&& sink) {
  if (is_strip<Real>(pair, axis, face_of_b, found)) return;
  if (face_of_b)
    for (box_contact<Real>& c : found) {
      c.normal = -(pair.axes * c.normal), c.point = pair.from_b(c.point);
      std::swap(c.a, c.b);
    }
  if (found.size() == 4) name_by_quarters(pair, found.template first<4>());
  vector3<Real> normal = column_of((face_of_b ? b : a).axes, axis);
  if (positive != face_of_b) normal = -normal;
  for (const box_contact<Real>& c : found)
    sink(contact_geometry{normal, a.to_world(c.point), c.gap, c.feature()});
}

/// Calls `sink(contact_geometry)` for two boxes that no axis separates by more than the margin.
/// `pair` and `gaps` are theirs, in the frame of a.
template <class Sink, class Real>
void collide_boxes(const box_place<Real>& a, const box_place<Real>& b, const box_pair<Real>& pair,
                   const box_gaps<Real>& gaps, Real margin, Sink&& sink) {
  const box_axes<Real> axes(pair, gaps);
  const Real smallest = pair.smallest();
  const Real best = axes.best();
  const auto tolerance = [&](Real gap) {
    return Real(0.005) * smallest + Real(0.05) * std::abs(gap);
  };
  const bool face_of_b = axes.face_b.gap > axes.face_a.gap + tolerance(axes.face_a.gap);
  const box_axis<Real>& face = face_of_b ? axes.face_b : axes.face_a;
  const bool by_face = !(axes.edge.gap > face.gap + tolerance(face.gap)) ||
                       axes.edge.normal.dot(face.normal) > Real(0.98);
  const bool apart = best > Real(1e-6) * smallest;

  if (by_face) {
    const box_pair<Real> turned = face_of_b ? pair.swapped() : pair;
    const bool positive = turned.offset[face.i] > 0 || (turned.offset[face.i] == 0 && !face_of_b);
    const auto over_face = [&](Real slack) {
      return box_manifold<Real>(turned, face.i, positive, margin, slack * smallest);
    };
    box_manifold<Real> patch = over_face(outline_slack<Real>);
    std::array<box_contact<Real>, 8> found;
    const auto points_of = [&](box_manifold<Real>& corners) {
      std::size_t size = 0;
      corners.for_each([&](const box_contact<Real>& c) { found[size++] = c; });
      return std::span(found.data(), size);
    };
    if (patch.empty() && std::abs(best) <= flush_strip<Real> * smallest) {
      box_manifold<Real> beside = over_face(flush_strip<Real>);
      if (!beside.empty() && is_strip<Real>(pair, face.i, face_of_b, points_of(beside))) return;
    }
    // The manifold must contain the nearest points, or nearly so.
    const Real enough =
        best + (apart ? Real(0.05) * best + Real(1e-4) * smallest : tolerance(best));
    bool use = patch.smallest_gap() <= enough;
    if (!use && !apart && !(axes.edge.gap >= face.gap)) {
      patch.use_lowest();
      use = true;
    }
    if (use) {
      patch.reduce(Real(1e-4) * smallest);
      give_patch(a, b, pair, face.i, positive, face_of_b, points_of(patch), sink);
      return;
    }
  }
  const box_contact<Real> single =
      apart ? nearest_points(pair, axes, margin) : crossing_edges(pair, axes);
  if (single.gap <= margin)
    sink(contact_geometry{-(a.axes * single.normal), a.to_world(single.point), single.gap,
                          single.feature()});
}

/// Calls `sink(contact_geometry)` for two boxes of a batch whose manifolds have been computed;
/// `lane` is their place in the batch.
template <class Sink, class Real>
void collide_lane(const box_place<Real>& a, const box_place<Real>& b, const box_batch<Real>& batch,
                  unsigned lane, Real margin, Sink&& sink) {
  const box_patches<Real>& patches = batch.patches();
  if (!patches.good(lane))
    return collide_boxes(a, b, batch.pair(lane), batch.gaps(lane), margin, sink);
  std::array<box_contact<Real>, 4> found;
  const std::size_t size = patches.corners(lane, found);
  give_patch(a, b, batch.pair(lane), patches.axis(lane), patches.positive(lane), patches.of_b(lane),
             std::span(found.data(), size), sink);
}

}  // namespace detail

/// Calls `sink(contact_geometry)` for the points with a gap of at most `margin`, in the order of
/// their features. The normal is the axis of least penetration; boxes apart get the direction of
/// their nearest points, unless a face serves as well. Faces of a are preferred to those of b, and
/// faces to edges, by half a percent of the smallest half edge and five percent of the gap (edges
/// crossing within 11 degrees of a face's normal count as that face), so that the choice holds
/// while a box rests on another. A feature names the parts of the two boxes that meet (for four
/// points, one in each quarter of a manifold, the corner of a on the same side). It does not depend
/// on the reference face, and is below 4096.
template <class Sink, class Real = real>
void collide(const box& a, const pose& pa, const box& b, const pose& pb, real margin, Sink&& sink) {
  using namespace detail;
  box_pair<Real> pair{a.half(), b.half(), matrix3<Real>(), pb.position - pa.position};
  const Real reach = pair.ha.norm() + pair.hb.norm() + margin;
  if (!(pair.offset.squaredNorm() <= reach * reach)) return;
  const auto in_a = place_of<Real>(a, pa), in_b = place_of<Real>(b, pb);
  Real axes[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      pair.axes(i, j) = axes[i][j] = in_a.axes(0, i) * in_b.axes(0, j) +
                                     in_a.axes(1, i) * in_b.axes(1, j) +
                                     in_a.axes(2, i) * in_b.axes(2, j);
  pair.offset = in_a.axes.transpose() * pair.offset;
  const box_gaps<Real> gaps =
      find_box_gaps<true>(pair.ha.data(), pair.hb.data(), axes, pair.offset.data(), margin);
  if (gaps.face_a > margin || gaps.face_b > margin || gaps.edge > margin * std::abs(margin)) return;
  collide_boxes(in_a, in_b, pair, gaps, margin, sink);
}

}  // namespace talus
