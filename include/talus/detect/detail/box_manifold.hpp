#pragma once
// The patch where a face of one box meets the other: the face opposite is clipped to the outline of
// the reference face (Sutherland, Hodgman 1974), and at most four of its corners are kept.
#include <array>

#include "talus/detect/detail/box_axes.hpp"

namespace talus::detail {

/// Corner of the patch: place in the reference face (u, v), height above it, and the parts of the
/// two boxes whose crossing it is.
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
  /// axis `axis`, to its positive or negative side.
  box_manifold(const box_pair<Real>& p, int axis, bool positive, Real margin)
      : axis_(axis),
        u_((axis + 1) % 3),
        v_((axis + 2) % 3),
        sign_(positive ? 1 : -1),
        half_(p.ha[axis]) {
    // The face of b that looks most towards the reference face.
    const vector3<Real> slope = p.axes.row(axis).transpose() * sign_;
    int m = 0;
    if (std::abs(slope[1]) > std::abs(slope[m])) m = 1;
    if (std::abs(slope[2]) > std::abs(slope[m])) m = 2;
    const int n = (m + 1) % 3, o = (m + 2) % 3;
    const bool looks_up = !(slope[m] > 0);
    constexpr bool around[4][2] = {{false, false}, {true, false}, {true, true}, {false, true}};
    for (const auto& at : around) {
      vector3<Real> local;
      local[m] = looks_up ? p.hb[m] : -p.hb[m];
      local[n] = at[0] ? p.hb[n] : -p.hb[n];
      local[o] = at[1] ? p.hb[o] : -p.hb[o];
      const vector3<Real> x = p.from_b(local);
      corners_[size_++] = {x[u_], x[v_], sign_ * x[axis] - p.ha[axis], side(axis, positive),
                           side(m, looks_up) | side(n, at[0]) | side(o, at[1])};
    }
    lowest_ = *std::min_element(corners_.begin(), corners_.begin() + 4,
                                [](auto& a, auto& b) { return a.gap < b.gap; });
    for (const bool far : {false, true}) {
      clip(&corner::u, far, p.ha[u_], side(u_, far));
      clip(&corner::v, far, p.ha[v_], side(v_, far));
    }
    unsigned kept = 0;
    for (unsigned k = 0; k < size_; ++k)
      if (corners_[k].gap <= margin) corners_[kept++] = corners_[k];
    size_ = kept;
  }

  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] Real smallest_gap() const {
    Real smallest = std::numeric_limits<Real>::infinity();
    for (unsigned k = 0; k < size_; ++k) smallest = std::min(smallest, corners_[k].gap);
    return smallest;
  }
  /// Falls back to the lowest corner of the incident face alone, wherever it is.
  void use_lowest() {
    corners_[0] = lowest_;
    size_ = 1;
  }

  /// Keeps four corners at most: those that span the largest area, and the deepest, unless one that
  /// is kept is as deep within `tolerance`. Ties go by small relative steps rather than to the
  /// last bit, so that the choice stays the same while a box rests.
  void reduce(Real tolerance) {
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
    for (unsigned k = 0; k < 4; ++k) corners_[k] = corners_[best[k]];
    size_ = 4;
  }

  /// Calls f(box_contact) for the corners, each name once.
  template <class F>
  void for_each(F&& f) {
    std::sort(corners_.begin(), corners_.begin() + size_, [](auto& a, auto& b) {
      return a.incident != b.incident ? a.incident < b.incident : a.reference < b.reference;
    });
    for (unsigned k = 0; k < size_; ++k) {
      const corner& c = corners_[k];
      // (The same corner can be there twice, where it lies on two sides.)
      if (k > 0 && c.incident == corners_[k - 1].incident &&
          c.reference == corners_[k - 1].reference)
        continue;
      box_contact<Real> out;
      out.normal = vector3<Real>::Zero();
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
  // Cuts off what lies beyond `half` on one side. A corner just outside, within a thousandth of
  // `half`, counts as inside, so that boxes of one size stacked flush keep their own corners.
  void clip(Real corner::*along, bool far, Real half, box_part wall) {
    const Real sign = far ? 1 : -1;
    const Real soft = half * Real(1.001);
    std::array<corner, 12> out;
    unsigned n = 0;
    for (unsigned k = 0; k < size_; ++k) {
      const corner& a = corners_[k];
      const corner& b = corners_[k + 1 < size_ ? k + 1 : 0];
      const Real da = sign * (a.*along), db = sign * (b.*along);
      const bool a_in = da <= soft, b_in = db <= soft;
      if (a_in) out[n++] = a;
      if (a_in == b_in || (a_in ? da : db) >= half) continue;
      const Real t = (half - da) / (db - da);
      corner cut{a.u + t * (b.u - a.u), a.v + t * (b.v - a.v), a.gap + t * (b.gap - a.gap),
                 (a.reference & b.reference) | wall, a.incident & b.incident};
      cut.*along = sign * half;
      out[n++] = cut;
    }
    size_ = std::min(n, 8u);
    std::copy(out.begin(), out.begin() + size_, corners_.begin());
  }

  [[nodiscard]] Real area_of(unsigned i, unsigned j, unsigned k, unsigned l) const {
    const corner &a = corners_[i], &b = corners_[j], &c = corners_[k], &d = corners_[l];
    return std::abs((c.u - a.u) * (d.v - b.v) - (c.v - a.v) * (d.u - b.u));
  }

  int axis_, u_, v_;
  Real sign_;
  Real half_;
  unsigned size_ = 0;
  std::array<corner, 8> corners_;
  corner lowest_;
};

/// Names four contacts by the quarter of the patch in which each lies, seen along the axes of a, if
/// there is clearly one in each; and sorts them. What parts of two boxes cross changes while one
/// slides on the other, the quarters do not: so impulses are remembered.
template <class Real>
void name_by_quarters(const box_pair<Real>& p, std::array<box_contact<Real>, 4>& c) {
  const vector3<Real>& normal = c[0].normal;
  const vector3<Real> seen_from_b = p.axes.transpose() * normal;
  int axis = 0, of_b = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  seen_from_b.cwiseAbs().maxCoeff(&of_b);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const vector3<Real> middle = Real(0.25) * (c[0].point + c[1].point + c[2].point + c[3].point);
  Real width[2] = {0, 0};
  for (const auto& k : c) {
    width[0] = std::max(width[0], std::abs(k.point[u] - middle[u]));
    width[1] = std::max(width[1], std::abs(k.point[v] - middle[v]));
  }
  unsigned seen = 0;
  std::array<box_part, 4> parts{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Real x = c[k].point[u] - middle[u], y = c[k].point[v] - middle[v];
    if (std::abs(x) < Real(0.1) * width[0] || std::abs(y) < Real(0.1) * width[1]) return;
    seen |= 1u << ((x > 0) + 2 * (y > 0));
    parts[k] = side(axis, normal[axis] > 0) | side(u, x > 0) | side(v, y > 0);
  }
  if (seen != 15) return;
  for (std::size_t k = 0; k < 4; ++k) {
    c[k].a = parts[k];
    c[k].b = side(of_b, seen_from_b[of_b] < 0);
  }
  std::sort(c.begin(), c.end(), [](auto& x, auto& y) { return x.feature() < y.feature(); });
}

}  // namespace talus::detail
