#pragma once
// The manifold of two convex shapes along their normal: the face or line of one is clipped to the
// outline of a face of the other (Sutherland, Hodgman 1974), or two parallel lines to their common
// part.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "talus/contact/contact_geometry.hpp"
#include "talus/core/portable_powers.hpp"
#include "talus/detect/detail/convex_view.hpp"

namespace talus::detail {

/// Corner of a manifold: its position in the plane of the reference face, the height of the other
/// core above it, and the parts of the two shapes that cross there.
template <class Real>
struct patch_point {
  Real u, v, height;
  part_code reference, incident;
  vector3<Real> at;  ///< on the incident core
};

/// Drops corners of a convex polygon, given in turn, that add nearly nothing to its area, and those
/// that add least until at most 16 are left, the lowest (within `tolerance`) among them. A corner
/// adds nearly nothing below `part` of the square of the extent of the polygon. A load may
/// act anywhere in the polygon, so that no smaller choice carries every load. Up to four corners
/// all stay. Of corners that add the same within small relative differences the first is dropped,
/// so that the choice is stable while a body rests.
template <class Real>
[[nodiscard]] int keep_outline(patch_point<Real>* p, int size, Real tolerance,
                               Real part = Real(1e-4)) {
  if (size <= 4) return size;
  patch_point<Real> lowest = p[0];
  Real extent = 0;
  for (int k = 1; k < size; ++k) {
    if (p[k].height < lowest.height) lowest = p[k];
    const Real u = p[k].u - p[0].u, v = p[k].v - p[0].v;
    extent = std::max(extent, u * u + v * v);
  }
  const auto added = [&](int k) {
    const auto &a = p[k > 0 ? k - 1 : size - 1], &b = p[k + 1 < size ? k + 1 : 0];
    return std::abs((p[k].u - a.u) * (b.v - a.v) - (p[k].v - a.v) * (b.u - a.u));
  };
  while (size > 4) {
    Real limit = part * extent;
    if (size > most_corners) {
      Real least = added(0);
      for (int k = 1; k < size; ++k) least = std::min(least, added(k));
      limit = std::max(limit, Real(1.001) * least);
    }
    int k = 0;
    while (k < size && !(added(k) < limit)) ++k;
    if (k == size && size <= most_corners) break;
    if (k == size) --k;  // all add nothing that can be compared
    std::copy(p + k + 1, p + size, p + k);
    --size;
  }
  const auto distance = [&](const patch_point<Real>& q) {
    return (q.u - lowest.u) * (q.u - lowest.u) + (q.v - lowest.v) * (q.v - lowest.v);
  };
  const auto lower = [](const auto& a, const auto& b) { return a.height < b.height; };
  if (lowest.height < std::min_element(p, p + size, lower)->height - tolerance)
    *std::min_element(p, p + size, [&](const auto& a, const auto& b) {
      return distance(a) < distance(b);
    }) = lowest;
  return size;
}

/// The incident outline over a reference face, as far as it lies within the face's sides.
template <class Real>
class convex_patch {
  using vector = vector3<Real>;

 public:
  using point = patch_point<Real>;

  /// A corner up to `slack` outside of a side counts as inside. A cut within `same` of a corner of
  /// one of the shapes has its name, so that shapes of one size stacked flush keep their corners.
  convex_patch(const outline<Real>& face, const vector& normal, const outline<Real>& incident,
               Real slack, Real same)
      : normal_(normal), origin_(face.corners[0].at), slack_(slack), same_(same), face_(face.face) {
    u_ = (face.corners[1].at - origin_).normalized();
    v_ = normal.cross(u_);
    for (int k = 0; k < incident.size; ++k) {
      const auto& c = incident.corners[static_cast<std::size_t>(k)];
      const vector x = c.at - origin_;
      points_[at(size_++)] = {
          {u_.dot(x), v_.dot(x), normal.dot(x), face.face, c.code, c.at}, c.edge, false, 0};
    }
    highest_ = size_ < 3 ? std::numeric_limits<Real>::infinity() : points_[0].height;
    for (int k = 1; k < size_; ++k) highest_ = std::max(highest_, points_[at(k)].height);
    line_ = incident.line();
    incident_face_ = incident.face;
    for (int k = 0; k < face.size && size_ > 0; ++k) clip(face, k);
  }

  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] Real lowest() const {
    Real least = std::numeric_limits<Real>::infinity();
    for (int k = 0; k < size_; ++k) least = std::min(least, points_[at(k)].height);
    return least;
  }
  /// Whether a flat side of the incident shape lies in the plane of the face or over it, within
  /// `width`, and the two overlap in a strip narrower than that: an edge of one body lies along an
  /// edge of the other, or will pass it.
  [[nodiscard]] bool is_strip(Real width) const {
    const Real low = lowest();
    if (size_ == 0 || !(low >= -width && highest_ - low <= width)) return false;
    Real area = 0, extent = 0;  // twice the area
    for (int k = 1; k < size_; ++k) {
      const point &first = points_[0], &p = points_[at(k)],
                  &q = points_[at(k + 1 < size_ ? k + 1 : 0)];
      const Real u = p.u - first.u, v = p.v - first.v;
      extent = std::max(extent, u * u + v * v);
      area += u * (q.v - first.v) - v * (q.u - first.u);
    }
    return std::abs(area) <= 2 * width * std::max(width, std::sqrt(extent));
  }
  /// Calls f(patch_point) for the points kept of those not higher than `limit`, at most 16; for
  /// `part` see keep_outline().
  template <class F>
  void for_each(Real limit, Real tolerance, Real part, F&& f) const {
    std::array<point, capacity> kept;
    int count = 0;
    const auto same = [&](const point& p, const point& q) {  // two cuts near one corner
      return p.reference == q.reference && p.incident == q.incident &&
             portable::hypot(p.u - q.u, p.v - q.v) <= 2 * same_;
    };
    for (int k = 0; k < size_; ++k)
      if (points_[at(k)].height <= limit &&
          !(count > 0 && same(points_[at(k)], kept[at(count - 1)])))
        kept[at(count++)] = points_[at(k)];
    if (count > 2 && same(kept[at(count - 1)], kept[0])) --count;
    count = keep_outline(kept.data(), count, tolerance, part);
    for (int k = 0; k < count; ++k) f(kept[at(k)]);
  }

 private:
  static constexpr int capacity = 2 * outline<Real>::capacity + 4;
  /// A corner and what runs from it to the next: an edge of the incident outline, or a side of the
  /// face.
  struct corner : point {
    part_code edge;
    bool on_side;
    int side;
  };
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }

  void clip(const outline<Real>& face, int k) {
    const auto& here = face.corners[at(k)];
    const auto& next = face.corners[at(k + 1 < face.size ? k + 1 : 0)];
    const vector p = here.at - origin_, q = next.at - origin_;
    const Real pu = u_.dot(p), pv = v_.dot(p);
    Real du = u_.dot(q) - pu, dv = v_.dot(q) - pv;
    const Real length = portable::hypot(du, dv);
    if (!(length > 0)) return;
    du /= length, dv /= length;
    const auto beyond = [&](const point& c) { return (c.u - pu) * dv - (c.v - pv) * du; };

    std::array<corner, capacity> out;
    int n = 0;
    const int edges = line_ ? 1 : size_;
    for (int c = 0; c < size_; ++c) {
      const corner &a = points_[at(c)], &b = points_[at(c + 1 < size_ ? c + 1 : 0)];
      const Real da = beyond(a), db = beyond(b);
      const bool a_in = da <= slack_, b_in = db <= slack_;
      if (a_in && n < capacity) out[at(n++)] = a;
      if (c >= edges || a_in == b_in || (a_in ? da : db) >= 0 || n >= capacity) continue;
      const Real t = da / (da - db);
      corner cut;
      cut.u = a.u + t * (b.u - a.u);
      cut.v = a.v + t * (b.v - a.v);
      cut.height = a.height + t * (b.height - a.height);
      cut.at = a.at + t * (b.at - a.at);
      const auto is_at = [&](Real u, Real v) {
        return portable::hypot(cut.u - u, cut.v - v) <= same_;
      };
      // The corner of the incident outline there, or of the face over the inside of the incident
      // face; else where an edge of the incident outline crosses this side.
      const bool before = a.on_side && a.side == (k > 0 ? k - 1 : face.size - 1);
      const bool after = a.on_side && a.side == (k + 1 < face.size ? k + 1 : 0);
      if (is_own(a) && is_at(a.u, a.v)) {
        cut.reference = face_, cut.incident = a.incident;
      } else if (is_own(b) && is_at(b.u, b.v)) {
        cut.reference = face_, cut.incident = b.incident;
      } else if (before || is_at(pu, pv)) {
        cut.reference = here.code, cut.incident = incident_face_;
      } else if (after || is_at(u_.dot(q), v_.dot(q))) {
        cut.reference = next.code, cut.incident = incident_face_;
      } else {
        cut.reference = here.edge, cut.incident = a.on_side ? incident_face_ : a.edge;
      }
      cut.edge = a_in ? here.edge : a.edge;
      cut.on_side = a_in ? true : a.on_side;
      cut.side = a_in ? k : a.side;
      out[at(n++)] = cut;
    }
    line_ = line_ && n == 2;
    size_ = n;
    std::copy(out.begin(), out.begin() + n, points_.begin());
  }

  /// Whether a point has the name of a corner of the incident outline.
  [[nodiscard]] bool is_own(const corner& c) const { return c.reference == face_; }

  vector normal_, origin_, u_, v_;
  Real slack_, same_;
  Real highest_;  ///< corner of the incident side before it is clipped; infinite if it is no side
  std::array<corner, capacity> points_;
  int size_ = 0;
  bool line_ = false;
  part_code face_, incident_face_ = 0;
};

}  // namespace talus::detail
