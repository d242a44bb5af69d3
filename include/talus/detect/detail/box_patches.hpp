#pragma once
// The manifolds of eight pairs of boxes at once, with at most four corners each. box_manifold
// computes single ones of any kind.
#include <array>
#include <bit>
#include <cstdint>

#include "talus/core/pack.hpp"
#include "talus/detect/box_place.hpp"
#include "talus/detect/detail/box_axes.hpp"
#include "talus/detect/detail/box_manifold.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// The incident face is clipped to the outline of the reference face without a polygon. The result
/// has corners of three kinds: its own corners inside, crossings of its edges with the outline, and
/// corners of the reference face inside it. The choice of the reference face, the tolerance of
/// corners and their names are as in collide_boxes() and box_manifold. If an edge passes a corner
/// of the outline within outline_slack, the result may be another corner within that distance.
template <class Real>
class box_patches {
  using number = pack<Real, 8>;
  using mask = mask_of<number>;

 public:
  /// Boxes as for find_box_gaps(), whose results are `gaps`.
  void find(const number (&ha)[3], const number (&hb)[3], const number (&c)[3][3],
            const number (&d)[3], const box_gaps<number>& gaps, const number& margin) {
    const number zero{};
    const auto magnitude = [](const number& x) { return x < 0 ? -x : x; };
    const auto less = [](const number& x, const number& y) { return x < y ? x : y; };
    const auto more = [](const number& x, const number& y) { return x > y ? x : y; };
    number smallest = less(less(ha[0], ha[1]), ha[2]);
    smallest = less(smallest, less(less(hb[0], hb[1]), hb[2]));
    const auto tolerance = [&](const number& gap) {
      return 0.005 * smallest + 0.05 * magnitude(gap);
    };
    of_b_ = gaps.face_b > gaps.face_a + tolerance(gaps.face_a);
    const number face = of_b_ ? gaps.face_b : gaps.face_a;
    const number root = square_root(magnitude(gaps.edge));
    const number edge = gaps.edge < zero ? -root : root;
    good_ = ~(edge > face + tolerance(face)) | edge_near_face(c, d, gaps);
    const number best = more(more(gaps.face_a, gaps.face_b), edge);
    const mask apart = best > 1e-6 * smallest;
    const number enough = best + (apart ? 0.05 * best + 1e-4 * smallest : tolerance(best));

    // The frame of the reference face, its axis first.
    axis_ = of_b_ ? gaps.axis_b : gaps.axis_a;
    const mask is_0 = axis_ == zero, is_1 = axis_ == zero + 1;
    const auto turned = [&](const number& x, const number& y, const number& z) {
      return is_0 ? x : is_1 ? y : z;
    };
    number row[3][3], at[3], half[3], other[3];
    {
      number t[3][3], o[3], h[3];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) t[i][j] = of_b_ ? c[j][i] : c[i][j];
        const number back = c[0][i] * d[0] + c[1][i] * d[1] + c[2][i] * d[2];
        o[i] = of_b_ ? -back : d[i];
        h[i] = of_b_ ? hb[i] : ha[i];
        other[i] = of_b_ ? ha[i] : hb[i];
      }
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int l = 0; l < 3; ++l) row[i][l] = turned(t[i][l], t[j][l], t[k][l]);
        at[i] = turned(o[i], o[j], o[k]);
        half[i] = turned(h[i], h[j], h[k]);
      }
    }
    positive_ = (at[0] > zero) | ((at[0] == zero) & ~of_b_);
    const number sign = positive_ ? zero + 1 : zero - 1;
    half_ = half[0];
    const number hu = half[1], hv = half[2];

    // The face of the other box that faces it most, and its centre and half edges.
    const number s0 = magnitude(row[0][0]), s1 = magnitude(row[0][1]), s2 = magnitude(row[0][2]);
    const mask m_1 = s1 > s0, m_2 = s2 > (m_1 ? s1 : s0);
    incident_ = m_2 ? zero + 2 : m_1 ? zero + 1 : zero;
    const auto chosen = [&](const number* x, int shift) {
      return m_2 ? x[(2 + shift) % 3] : m_1 ? x[(1 + shift) % 3] : x[shift];
    };
    up_ = ~(sign * chosen(row[0], 0) > zero);
    const auto seen = [&](int shift, number(&out)[3]) {
      const number length = chosen(other, shift);
      out[0] = length * chosen(row[1], shift);
      out[1] = length * chosen(row[2], shift);
      out[2] = length * sign * chosen(row[0], shift);
    };
    number m[3], x[3], y[3], centre[3];
    seen(0, m), seen(1, x), seen(2, y);
    const number place[3] = {at[1], at[2], sign * at[0] - half_};
    for (int i = 0; i < 3; ++i) centre[i] = place[i] + (up_ ? m[i] : -m[i]);

    lowest_ = zero + std::numeric_limits<Real>::infinity();
    found_ = mask{};
    const auto put = [&](int k, const number& u, const number& v, const number& gap,
                         const mask& there) {
      u_[k] = u, v_[k] = v, gap_[k] = gap;
      const mask kept = there & (gap <= margin);
      found_ |= kept & (mask{} + (std::int64_t{1} << k));
      lowest_ = kept ? less(lowest_, gap) : lowest_;
    };
    const number slack = outline_slack<Real> * smallest, limit_u = hu + slack, limit_v = hv + slack;
    number corner[4][3];
    for (int i = 0; i < 3; ++i) {
      const number low = centre[i] - x[i], high = centre[i] + x[i];
      corner[0][i] = low - y[i], corner[1][i] = high - y[i];
      corner[2][i] = high + y[i], corner[3][i] = low + y[i];
    }
    for (int k = 0; k < 4; ++k) {
      const number &u = corner[k][0], &v = corner[k][1];
      put(k, u, v, corner[k][2], (magnitude(u) <= limit_u) & (magnitude(v) <= limit_v));
    }
    // Entries into the outline and exits from it must match: their numbers are equal, and its
    // corners lie between leaving by one side and entering by another.
    mask doubtful{}, entries{}, sides{}, outline{};
    for (int k = 0; k < 4; ++k) {
      const number(&p)[3] = corner[k], (&q)[3] = corner[(k + 1) % 4];
      const number du = q[0] - p[0], dv = q[1] - p[1], dg = q[2] - p[2];
      const number inverse_u = 1 / du, inverse_v = 1 / dv;
      // An end beyond a side of the outline is cut off. If the other end is just outside, there is
      // no cut; if it is as far, the edge vanishes.
      const auto cut = [&](const number& out, const number& in, const number& start,
                           const number& h, const number& limit, const number& inverse, mask& cuts,
                           mask& dead, number& wall, number& t) {
        const number beyond = out < zero ? -in : in;
        const mask is_out = magnitude(out) > limit;
        cuts = is_out & (beyond < h);
        dead |= is_out & (beyond > limit);
        doubtful |= is_out & (beyond >= h) & (beyond <= limit);
        wall = out < zero ? -h : h;
        t = (wall - start) * inverse;
      };
      mask dead{}, in_u, in_v, out_u, out_v;
      number wall_in_u, wall_in_v, wall_out_u, wall_out_v, t_in_u, t_in_v, t_out_u, t_out_v;
      cut(p[0], q[0], p[0], hu, limit_u, inverse_u, in_u, dead, wall_in_u, t_in_u);
      cut(p[1], q[1], p[1], hv, limit_v, inverse_v, in_v, dead, wall_in_v, t_in_v);
      cut(q[0], p[0], p[0], hu, limit_u, inverse_u, out_u, dead, wall_out_u, t_out_u);
      cut(q[1], p[1], p[1], hv, limit_v, inverse_v, out_v, dead, wall_out_v, t_out_v);
      const mask first_u = in_u & ~(in_v & (t_in_v > t_in_u));
      const mask last_u = out_u & ~(out_v & (t_out_v < t_out_u));
      const number first = first_u ? t_in_u : t_in_v, last = last_u ? t_out_u : t_out_v;
      const mask enters = (in_u | in_v) & ~dead, leaves = (out_u | out_v) & ~dead;
      // An edge past a corner of the outline, within the tolerance, counts once.
      const mask crossed = enters & leaves & (first > last);
      const auto put_cut = [&](int slot, const number& t, const mask& there, const mask& by_u,
                               const number& wall_u, const number& wall_v, int sense) {
        const number u = by_u ? wall_u : p[0] + t * du, v = by_u ? p[1] + t * dv : wall_v;
        side_[slot - 4] = by_u ? (wall_u > zero ? mask{} + 1 : mask{})
                               : (wall_v > zero ? mask{} + 3 : mask{} + 2);
        const mask cuts =
            there & (magnitude(u) <= limit_u) & (magnitude(v) <= limit_v) & ~(crossed & ~by_u);
        // Sides in their order around: u+, v+, u-, v-.
        const mask turn = by_u ? (wall_u > zero ? mask{} : mask{} + 2)
                               : (wall_v > zero ? mask{} + 1 : mask{} + 3);
        entries += cuts & (mask{} + sense), sides += cuts & (sense * turn);
        put(slot, u, v, p[2] + t * dg, cuts);
      };
      put_cut(4 + k, first, enters, first_u, wall_in_u, wall_in_v, 1);
      put_cut(8 + k, last, leaves, last_u, wall_out_u, wall_out_v, -1);
    }
    // A corner of the outline, as (s, t) in the incident face; inside if it is so by the slack.
    const number area = x[0] * y[1] - x[1] * y[0], scale = 1 / area;
    const number s_u = scale * y[1], s_v = -scale * y[0], t_u = -scale * x[1], t_v = scale * x[0];
    for (int k = 0; k < 4; ++k) {
      const number u = k & 1 ? hu : -hu, v = k & 2 ? hv : -hv;
      const number from_u = u - centre[0], from_v = v - centre[1];
      const number s = s_u * from_u + s_v * from_v, t = t_u * from_u + t_v * from_v;
      const auto within = [&](const number& a, const number& b) {
        return (magnitude(a) <= zero + 1) & (magnitude(b) <= zero + 1);
      };
      const number by_u = k & 1 ? slack : -slack, by_v = k & 2 ? slack : -slack;
      const mask inside =
          within(s + s_u * by_u, t + t_u * by_u) & within(s + s_v * by_v, t + t_v * by_v);
      outline -= inside;
      put(12 + k, u, v, centre[2] + s * x[2] + t * y[2], inside);
    }
    sides = area > zero ? sides : -sides;
    doubtful |= (entries != mask{}) | (((sides - outline) & (mask{} + 3)) != mask{});
    good_ &= (lowest_ <= enough) & ~doubtful;
  }

  /// Whether the manifold of a lane equals that of collide_boxes(), and has at most four corners.
  [[nodiscard]] bool good(unsigned lane) const {
    return good_[lane] != 0 && std::popcount(static_cast<unsigned>(found_[lane])) <= 4;
  }
  [[nodiscard]] bool of_b(unsigned lane) const { return of_b_[lane] != 0; }
  [[nodiscard]] int axis(unsigned lane) const { return static_cast<int>(axis_[lane]); }
  [[nodiscard]] bool positive(unsigned lane) const { return positive_[lane] != 0; }

  /// Writes the corners, in the frame of the reference, in the order of their names; returns how
  /// many. (The reference counts as a.)
  std::size_t corners(unsigned lane, std::array<box_contact<Real>, 4>& out) const {
    const int axis = this->axis(lane), u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int m = static_cast<int>(incident_[lane]), n = (m + 1) % 3, o = (m + 2) % 3;
    const box_part face = side(m, up_[lane] != 0), reference = side(axis, positive(lane));
    const Real sign = positive(lane) ? 1 : -1;
    std::uint32_t names[4];
    std::size_t size = 0;
    for (auto left = static_cast<unsigned>(found_[lane]); left != 0; left &= left - 1) {
      const int k = std::countr_zero(left), of = k & 3;
      box_part b = face, a = reference;
      if (k < 4) {
        b |= side(n, of == 1 || of == 2) | side(o, of >= 2);
      } else if (k < 12) {  // edges 0 and 2 run along n, 1 and 3 along o
        b |= of & 1 ? side(n, of == 1) : side(o, of == 2);
        const auto wall = side_[k - 4][lane];
        a |= side(wall & 2 ? v : u, wall & 1);
      } else {
        a |= side(u, of & 1) | side(v, of & 2);
      }
      const std::uint32_t name = b << 6 | a;
      std::size_t at = size++;
      for (; at > 0 && names[at - 1] > name; --at) names[at] = names[at - 1], out[at] = out[at - 1];
      names[at] = name;
      box_contact<Real>& c = out[at];
      c.normal = {0, 0, 0};
      c.normal[axis] = sign;
      c.gap = gap_[k][lane];
      c.point[u] = u_[k][lane], c.point[v] = v_[k][lane];
      c.point[axis] = sign * (half_[lane] + Real(0.5) * c.gap);
      c.a = a, c.b = b;
    }
    return size;
  }

 private:
  /// Whether edges cross within 11 degrees of the normal of the reference face.
  [[nodiscard]] [[gnu::always_inline]] mask edge_near_face(const number (&c)[3][3],
                                                           const number (&d)[3],
                                                           const box_gaps<number>& gaps) const {
    const number zero{};
    // The directions of b and of a, which count 0, 1, 2 in the numbers of pairs of edges.
    const mask a_1 = gaps.axes > 2.5, a_2 = gaps.axes > 5.5;
    const number j = gaps.axes - (a_2 ? zero + 6 : a_1 ? zero + 3 : zero);
    const auto column = [&](const number& k, number(&out)[3]) {
      const mask is_0 = k == zero, is_1 = k == zero + 1;
      for (int i = 0; i < 3; ++i) out[i] = is_0 ? c[i][0] : is_1 ? c[i][1] : c[i][2];
    };
    number b[3], face[3];
    column(j, b), column(gaps.axis_b, face);
    const number n[3] = {a_2   ? -b[1]
                         : a_1 ? b[2]
                               : zero,
                         a_2   ? b[0]
                         : a_1 ? zero
                               : -b[2],
                         a_2   ? zero
                         : a_1 ? -b[0]
                               : b[1]};
    for (int i = 0; i < 3; ++i)
      face[i] = of_b_ ? face[i] : gaps.axis_a == zero + i ? zero + 1 : zero;
    const auto along = [](const number(&x)[3], const number(&y)[3]) {
      return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    };
    // Both normals from a towards b.
    const mask turned = (along(n, d) < zero) ^ (along(face, d) < zero);
    const number both = along(n, face), cosine = turned ? -both : both;
    constexpr Real near = 0.98;
    return (cosine > zero) & (cosine * cosine > near * near * along(n, n));
  }

  static constexpr int kinds = 16;

  number u_[kinds], v_[kinds], gap_[kinds];
  mask side_[8];  ///< of a crossing: 0 and 1 are the sides of u, 2 and 3 those of v
  number axis_, incident_, half_, lowest_;
  mask of_b_, positive_, up_, found_, good_;
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
