#pragma once
// The manifold of a face of one box and the other box: the opposite face is clipped to the outline
// of the reference face (Sutherland, Hodgman 1974). Four of its corners are kept if they carry both
// boxes, else all.
#include <array>
#include <span>

#include "talus/detect/detail/box_axes.hpp"

namespace talus::detail {

/// Corner of the manifold: position in the reference face (u, v), height above it, and the parts of
/// the two boxes that cross there.
template <class Real>
struct patch_corner {
  Real u, v, gap;
  box_part reference, incident;
};

template <class Real>
class box_manifold {
  using corner = patch_corner<Real>;

 public:
  /// Corners with a gap of at most `margin` of the patch over the face of a that looks along
  /// axis `axis`, to its positive or negative side. A corner up to `slack` outside of that face
  /// counts as inside.
  box_manifold(const box_pair<Real>& p, int axis, bool positive, Real margin, Real slack)
      : axis_(axis),
        u_((axis + 1) % 3),
        v_((axis + 2) % 3),
        sign_(positive ? 1 : -1),
        half_(p.ha[axis]),
        slack_(slack),
        other_u_(p.offset[u_]),
        other_v_(p.offset[v_]) {
    // The face of b that faces the reference face most.
    const Real slope[3] = {p.axes(axis, 0), p.axes(axis, 1), p.axes(axis, 2)};
    int m = 0;
    if (std::abs(slope[1]) > std::abs(slope[m])) m = 1;
    if (std::abs(slope[2]) > std::abs(slope[m])) m = 2;
    const int n = (m + 1) % 3, o = (m + 2) % 3;
    const bool looks_up = !(sign_ * slope[m] > 0);
    const auto seen = [&](int k, Real length) {
      return vector3<Real>{length * p.axes(u_, k), length * p.axes(v_, k),
                           length * sign_ * p.axes(axis_, k)};
    };
    const vector3<Real> centre =
        vector3<Real>{p.offset[u_], p.offset[v_], sign_ * p.offset[axis] - half_} +
        seen(m, looks_up ? p.hb[m] : -p.hb[m]);
    const vector3<Real> x = seen(n, p.hb[n]), y = seen(o, p.hb[o]);
    const box_part face = side(m, looks_up), reference = side(axis, positive);
    const auto put = [&](const vector3<Real>& at, bool far_n, bool far_o) {
      corners_[size_++] = {at[0], at[1], at[2], reference, face | side(n, far_n) | side(o, far_o)};
    };
    put(centre - x - y, false, false);
    put(centre + x - y, true, false);
    put(centre + x + y, true, true);
    put(centre - x + y, false, true);
    lowest_ = corners_[0];
    for (unsigned k = 1; k < 4; ++k)
      if (corners_[k].gap < lowest_.gap) lowest_ = corners_[k];
    // Only sides that cut need clipping.
    const Real u_width = std::abs(x[0]) + std::abs(y[0]), v_width = std::abs(x[1]) + std::abs(y[1]);
    for (const bool far : {false, true}) {
      const Real sign = far ? 1 : -1;
      if (size_ > 0 && sign * centre[0] + u_width > p.ha[u_] + slack_)
        clip(&corner::u, far, p.ha[u_], side(u_, far));
      if (size_ > 0 && sign * centre[1] + v_width > p.ha[v_] + slack_)
        clip(&corner::v, far, p.ha[v_], side(v_, far));
    }
    unsigned kept = 0;
    for (unsigned k = 0; k < size_; ++k) {
      if (!(corners_[k].gap <= margin)) continue;
      if (kept != k) corners_[kept] = corners_[k];
      ++kept;
    }
    size_ = kept;
  }

  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] Real smallest_gap() const {
    Real smallest = std::numeric_limits<Real>::infinity();
    for (unsigned k = 0; k < size_; ++k) smallest = std::min(smallest, corners_[k].gap);
    return smallest;
  }
  /// Falls back to the lowest corner of the incident face alone, at any position.
  void use_lowest() {
    corners_[0] = lowest_;
    size_ = 1;
  }

  /// Keeps four corners: those that span the largest area, and the deepest, unless a kept one is as
  /// deep within `tolerance`. Ties are decided by small relative differences rather than the last
  /// bit, so that the choice is stable while a box rests. All corners stay if a box rests on the
  /// patch so far out that four may not carry it.
  void reduce(Real tolerance) {
    drop_flat_corners();
    if (size_ <= 4) return;
    std::array<unsigned, 4> best{};
    Real largest = -1;
    for (unsigned i = 0; i < size_; ++i)
      for (unsigned j = i + 1; j < size_; ++j)
        for (unsigned k = j + 1; k < size_; ++k)
          for (unsigned l = k + 1; l < size_; ++l) {
            const Real area = area_of(i, j, k, l);
            if (largest < 0 || area > largest * Real(1.001)) {
              largest = area;
              best = {i, j, k, l};
            }
          }
    unsigned deepest = 0;
    for (unsigned k = 1; k < size_; ++k)
      if (corners_[k].gap < corners_[deepest].gap) deepest = k;
    Real covered = std::numeric_limits<Real>::infinity();
    for (const unsigned k : best) covered = std::min(covered, corners_[k].gap);
    if (corners_[deepest].gap < covered - tolerance) {
      std::array<unsigned, 4> with = best;
      largest = -1;
      for (unsigned drop = 0; drop < 4; ++drop) {
        std::array<unsigned, 4> trial = best;
        trial[drop] = deepest;
        std::sort(trial.begin(), trial.end());
        const Real area = area_of(trial[0], trial[1], trial[2], trial[3]);
        if (area > largest * Real(1.001)) {
          largest = area;
          with = trial;
        }
      }
      best = with;
    }
    if (!carries(best)) return;
    for (unsigned k = 0; k < 4; ++k) corners_[k] = corners_[best[k]];
    size_ = 4;
  }

  /// Calls f(box_contact) for the corners, each name once, in the order of their names.
  template <class F>
  void for_each(F&& f) {
    const auto name = [&](unsigned k) { return corners_[k].incident << 6 | corners_[k].reference; };
    std::array<unsigned, 8> order;
    for (unsigned k = 0; k < size_; ++k) {
      unsigned at = k;
      for (; at > 0 && name(order[at - 1]) > name(k); --at) order[at] = order[at - 1];
      order[at] = k;
    }
    for (unsigned k = 0; k < size_; ++k) {
      // (A corner that lies on two sides can occur twice.)
      if (k > 0 && name(order[k]) == name(order[k - 1])) continue;
      const corner& c = corners_[order[k]];
      box_contact<Real> out;
      out.normal = {0, 0, 0};
      out.normal[axis_] = sign_;
      out.point[u_] = c.u;
      out.point[v_] = c.v;
      out.point[axis_] = sign_ * (half_ + Real(0.5) * c.gap);
      out.gap = c.gap;
      out.a = c.reference;
      out.b = c.incident;
      f(out);
    }
  }

 private:
  /// Drops corners that add less to the area than a thousandth of the square of the extent, the
  /// least first, down to four: where edges of the two boxes nearly coincide, they are as near to
  /// other corners, and come and go while the boxes tremble.
  void drop_flat_corners() {
    if (size_ <= 4) return;
    Real extent = 0;
    for (unsigned k = 1; k < size_; ++k) {
      const Real u = corners_[k].u - corners_[0].u, v = corners_[k].v - corners_[0].v;
      extent = std::max(extent, u * u + v * v);
    }
    const auto added = [&](unsigned k) {
      const corner &a = corners_[k > 0 ? k - 1 : size_ - 1], &p = corners_[k],
                   &b = corners_[k + 1 < size_ ? k + 1 : 0];
      return std::abs((p.u - a.u) * (b.v - a.v) - (p.v - a.v) * (b.u - a.u));
    };
    while (size_ > 4) {
      unsigned flattest = 0;
      Real least = added(0);
      for (unsigned k = 1; k < size_; ++k)
        if (const Real area = added(k); area < Real(0.999) * least) least = area, flattest = k;
      if (!(least < Real(1e-3) * extent)) return;
      std::copy(corners_.begin() + flattest + 1, corners_.begin() + size_,
                corners_.begin() + flattest);
      --size_;
    }
  }
  // Cuts off the part beyond `half` on one side.
  void clip(Real corner::*along, bool far, Real half, box_part wall) {
    const Real sign = far ? 1 : -1;
    const Real limit = half + slack_;
    const std::array<corner, 8> in = corners_;
    const unsigned size = size_;
    unsigned n = 0;
    const auto put = [&](const corner& c) {
      if (n < 8) corners_[n++] = c;
    };
    Real da = sign * (in[size - 1].*along);
    for (unsigned k = 0, before = size - 1; k < size; before = k++) {
      const corner &a = in[before], &b = in[k];
      const Real db = sign * (b.*along);
      const bool a_in = da <= limit, b_in = db <= limit;
      if (a_in != b_in && (a_in ? da : db) < half) {
        const Real t = (half - da) / (db - da);
        corner cut{a.u + t * (b.u - a.u), a.v + t * (b.v - a.v), a.gap + t * (b.gap - a.gap),
                   (a.reference & b.reference) | wall, a.incident & b.incident};
        cut.*along = sign * half;
        put(cut);
      }
      if (b_in) put(b);
      da = db;
    }
    size_ = n;
  }

  /// Whether the centre of each box that lies over the patch lies within half of these four
  /// corners, which leaves as much room for other loads.
  [[nodiscard]] bool carries(const std::array<unsigned, 4>& four) const {
    Real u = 0, v = 0;
    for (const unsigned k : four) u += Real(0.25) * corners_[k].u, v += Real(0.25) * corners_[k].v;
    constexpr std::array<unsigned, 8> all{0, 1, 2, 3, 4, 5, 6, 7};
    const auto out = [](Real x, Real middle) { return x + Real(0.5) * (x - middle); };
    const auto carried = [&](Real x, Real y) {
      return !contains(all.data(), size_, x, y) || contains(four.data(), 4, out(x, u), out(y, v));
    };
    return carried(0, 0) && carried(other_u_, other_v_);
  }
  /// Whether a point lies inside the convex polygon of these corners, in turn.
  [[nodiscard]] bool contains(const unsigned* of, unsigned size, Real u, Real v) const {
    bool left = true, right = true;
    for (unsigned k = 0; k < size; ++k) {
      const corner &a = corners_[of[k]], &b = corners_[of[k + 1 < size ? k + 1 : 0]];
      const Real side = (b.u - a.u) * (v - a.v) - (b.v - a.v) * (u - a.u);
      left = left && side >= 0, right = right && side <= 0;
    }
    return left || right;
  }

  [[nodiscard]] Real area_of(unsigned i, unsigned j, unsigned k, unsigned l) const {
    const corner &a = corners_[i], &b = corners_[j], &c = corners_[k], &d = corners_[l];
    return std::abs((c.u - a.u) * (d.v - b.v) - (c.v - a.v) * (d.u - b.u));
  }

  int axis_, u_, v_;
  Real sign_;
  Real half_, slack_;
  Real other_u_, other_v_;  ///< where the centre of the other box lies over the face
  unsigned size_ = 0;
  std::array<corner, 8> corners_;
  corner lowest_;
};

/// Names four contacts by their quarter of the manifold along the axes of a, if each quarter
/// clearly has one, and sorts them. The crossing parts of two boxes change while one slides on the
/// other, but the quarters do not, so that warm start finds the impulses.
template <class Real>
void name_by_quarters(const box_pair<Real>& p, std::span<box_contact<Real>, 4> c) {
  const vector3<Real>& normal = c[0].normal;
  const vector3<Real> seen_from_b = p.axes.transpose() * normal;
  const auto largest = [](const vector3<Real>& v) {
    int k = 0;
    if (std::abs(v[1]) > std::abs(v[k])) k = 1;
    if (std::abs(v[2]) > std::abs(v[k])) k = 2;
    return k;
  };
  const int axis = largest(normal), of_b = largest(seen_from_b);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  Real x[4], y[4], width[2] = {0, 0};
  for (std::size_t k = 0; k < 4; ++k) x[k] = c[k].point[u], y[k] = c[k].point[v];
  const Real middle_x = Real(0.25) * (x[0] + x[1] + x[2] + x[3]),
             middle_y = Real(0.25) * (y[0] + y[1] + y[2] + y[3]);
  for (std::size_t k = 0; k < 4; ++k) {
    x[k] -= middle_x, y[k] -= middle_y;
    width[0] = std::max(width[0], std::abs(x[k]));
    width[1] = std::max(width[1], std::abs(y[k]));
  }
  // The order of the quarters is that of the names: the parts of one axis make the larger ones.
  std::array<unsigned, 4> in_quarter{};
  unsigned seen = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (std::abs(x[k]) < Real(0.1) * width[0] || std::abs(y[k]) < Real(0.1) * width[1]) return;
    const unsigned high = u > v ? x[k] > 0 : y[k] > 0, low = u > v ? y[k] > 0 : x[k] > 0;
    in_quarter[2 * high + low] = static_cast<unsigned>(k);
    seen |= 1u << (2 * high + low);
  }
  if (seen != 15) return;
  const std::array<box_contact<Real>, 4> found{c[0], c[1], c[2], c[3]};
  for (std::size_t q = 0; q < 4; ++q) {
    const unsigned k = in_quarter[q];
    c[q] = found[k];
    c[q].a = side(axis, normal[axis] > 0) | side(u, x[k] > 0) | side(v, y[k] > 0);
    c[q].b = side(of_b, seen_from_b[of_b] < 0);
  }
}

}  // namespace talus::detail
