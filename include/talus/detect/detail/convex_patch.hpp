#pragma once
// The manifold of two convex shapes along their normal: the face or line of one is clipped to the
// outline of a face of the other (Sutherland, Hodgman 1974), or two parallel lines to their common
// part. At most four points are kept.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

/// Of many points, four that span much of their area, the lowest (within `tolerance`) among them.
/// Ties are decided by small relative differences rather than the last bit, so that the choice is
/// stable while a body rests. The order stays.
template <class Real>
[[nodiscard]] int keep_four(patch_point<Real>* p, int size, Real tolerance) {
  if (size <= 4) return size;
  constexpr Real more = Real(1.001);
  const auto pick = [&](auto&& score) {
    int best = -1;
    Real most = 0;
    for (int k = 0; k < size; ++k)
      if (const Real now = score(p[k]); now > most * more || (best < 0 && now > 0))
        most = now, best = k;
    return best;
  };
  Real low_u = p[0].u, low_v = p[0].v;
  for (int k = 1; k < size; ++k) low_u = std::min(low_u, p[k].u), low_v = std::min(low_v, p[k].v);
  int chosen[4], count = 0;
  const auto choose = [&](int k) {
    if (k >= 0) chosen[count++] = k;
  };
  choose(pick([&](auto& q) { return 4 * (q.u - low_u) + 3 * (q.v - low_v); }));
  if (count == 0) chosen[count++] = 0;
  const patch_point<Real> first = p[chosen[0]];
  const auto far = [&](auto& q) {
    return (q.u - first.u) * (q.u - first.u) + (q.v - first.v) * (q.v - first.v);
  };
  choose(pick(far));
  if (count == 2) {
    const Real u = p[chosen[1]].u - first.u, v = p[chosen[1]].v - first.v;
    const Real least = Real(1e-6) * (u * u + v * v);
    const auto area = [&](auto& q) { return u * (q.v - first.v) - v * (q.u - first.u); };
    choose(pick([&](auto& q) { return area(q) - least; }));
    choose(pick([&](auto& q) { return -area(q) - least; }));
  }
  int lowest = 0;
  for (int k = 1; k < size; ++k)
    if (p[k].height < p[lowest].height) lowest = k;
  Real covered = std::numeric_limits<Real>::infinity();
  for (int c = 0; c < count; ++c) covered = std::min(covered, p[chosen[c]].height);
  if (p[lowest].height < covered - tolerance) {
    if (count < 4) {
      chosen[count++] = lowest;
    } else {
      const auto distance = [&](int k) {
        return portable::hypot(p[k].u - p[lowest].u, p[k].v - p[lowest].v);
      };
      *std::min_element(chosen, chosen + 4,
                        [&](int k, int m) { return distance(k) < distance(m); }) = lowest;
    }
  }
  for (int c = 1; c < count; ++c)
    for (int d = c; d > 0 && chosen[d] < chosen[d - 1]; --d) std::swap(chosen[d], chosen[d - 1]);
  for (int c = 0; c < count; ++c) p[c] = p[chosen[c]];
  return count;
}

/// The incident outline over a reference face, as far as it lies within the face's sides.
template <class Real>
class convex_patch {
  using vector = vector3<Real>;

 public:
  using point = patch_point<Real>;

  /// `soft` is how far outside of a side a corner still counts as inside, so that shapes of one
  /// size stacked flush keep their own corners.
  convex_patch(const outline<Real>& face, const vector& normal, const outline<Real>& incident,
               Real soft)
      : normal_(normal), origin_(face.corners[0].at) {
    u_ = (face.corners[1].at - origin_).normalized();
    v_ = normal.cross(u_);
    for (int k = 0; k < incident.size; ++k) {
      const auto& c = incident.corners[static_cast<std::size_t>(k)];
      const vector x = c.at - origin_;
      points_[at(size_++)] = {
          {u_.dot(x), v_.dot(x), normal.dot(x), face.face, c.code, c.at}, c.edge, false, 0};
    }
    line_ = incident.line();
    incident_face_ = incident.face;
    for (int k = 0; k < face.size && size_ > 0; ++k) clip(face, k, soft);
  }

  [[nodiscard]] Real lowest() const {
    Real least = std::numeric_limits<Real>::infinity();
    for (int k = 0; k < size_; ++k) least = std::min(least, points_[at(k)].height);
    return least;
  }
  /// Calls f(patch_point) for the points kept of those not higher than `limit`.
  template <class F>
  void for_each(Real limit, Real tolerance, F&& f) const {
    std::array<point, capacity> kept;
    int count = 0;
    for (int k = 0; k < size_; ++k)
      if (points_[at(k)].height <= limit) kept[at(count++)] = points_[at(k)];
    count = keep_four(kept.data(), count, tolerance);
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

  void clip(const outline<Real>& face, int k, Real soft) {
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
      const bool a_in = da <= soft, b_in = db <= soft;
      if (a_in && n < capacity) out[at(n++)] = a;
      if (c >= edges || a_in == b_in || (a_in ? da : db) >= 0 || n >= capacity) continue;
      const Real t = da / (da - db);
      corner cut;
      cut.u = a.u + t * (b.u - a.u);
      cut.v = a.v + t * (b.v - a.v);
      cut.height = a.height + t * (b.height - a.height);
      cut.at = a.at + t * (b.at - a.at);
      // Where an edge of the incident outline crosses this side; or, where two sides meet, the
      // face's corner over the inside of the incident face.
      if (!a.on_side) {
        cut.reference = here.edge;
        cut.incident = a.edge;
      } else {
        const bool before = a.side == (k > 0 ? k - 1 : face.size - 1);
        const bool after = a.side == (k + 1 < face.size ? k + 1 : 0);
        cut.reference = before ? here.code : after ? next.code : here.edge;
        cut.incident = incident_face_;
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

  vector normal_, origin_, u_, v_;
  std::array<corner, capacity> points_;
  int size_ = 0;
  bool line_ = false;
  part_code incident_face_ = 0;
};

}  // namespace talus::detail
