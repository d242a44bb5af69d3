#pragma once
// Vectors and matrices of several things at once.
#include <cstddef>
#include <type_traits>

#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Three components of as many things as a pack has lanes.
template <class Pack>
struct pack_vector {
  Pack x, y, z;

  [[gnu::always_inline]] friend pack_vector operator+(const pack_vector& a, const pack_vector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  [[gnu::always_inline]] friend pack_vector<Pack> operator-(const pack_vector<Pack>& a,
                                                            const pack_vector<Pack>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  [[gnu::always_inline]] friend pack_vector<Pack> operator*(const Pack& s,
                                                            const pack_vector<Pack>& a) {
    return {s * a.x, s * a.y, s * a.z};
  }
  [[gnu::always_inline]] void operator+=(const pack_vector<Pack>& a) {
    x += a.x, y += a.y, z += a.z;
  }
  [[gnu::always_inline]] void operator-=(const pack_vector<Pack>& a) {
    x -= a.x, y -= a.y, z -= a.z;
  }
};
/// A vector of each lane; of one lane the vector itself.
template <class Pack>
using vectors_of =
    std::conditional_t<lanes_of<Pack> == 1, vector3<lane_of<Pack>>, pack_vector<Pack>>;
/// The number, or pack of numbers, of which a vector has three.
template <class Vector>
struct number_in;
template <class Real>
struct number_in<vector3<Real>> {
  using type = Real;
};
template <class Pack>
struct number_in<pack_vector<Pack>> {
  using type = Pack;
};
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline vectors_of<Pack> every_lane_of(lane_of<Pack> x,
                                                                           lane_of<Pack> y,
                                                                           lane_of<Pack> z) {
  return {every_lane<Pack>(x), every_lane<Pack>(y), every_lane<Pack>(z)};
}
/// Lane by lane, a where the mask holds, b elsewhere.
template <class Real>
[[nodiscard]] [[gnu::always_inline]] inline vector3<Real> choose(bool m, const vector3<Real>& a,
                                                                 const vector3<Real>& b) {
  return m ? a : b;
}
template <class Mask, class Pack>
[[nodiscard]] [[gnu::always_inline]] inline pack_vector<Pack> choose(const Mask& m,
                                                                     const pack_vector<Pack>& a,
                                                                     const pack_vector<Pack>& b) {
  return {choose(m, a.x, b.x), choose(m, a.y, b.y), choose(m, a.z, b.z)};
}
/// The first three numbers of rows.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline vectors_of<Pack> vectors_in(
    const pack_rows<Pack>& rows) {
  return {rows.x, rows.y, rows.z};
}
/// What lane l holds, and the reverse.
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline auto lane(const Pack& p, std::size_t l) {
  if constexpr (std::is_arithmetic_v<Pack>)
    return p;
  else
    return p[l];
}
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline vector3<lane_of<Pack>> lane(const pack_vector<Pack>& v,
                                                                        std::size_t l) {
  return {lane(v.x, l), lane(v.y, l), lane(v.z, l)};
}
template <class Pack>
[[gnu::always_inline]] inline void put_lane(Pack& p, std::size_t l, const auto& number) {
  if constexpr (std::is_arithmetic_v<Pack>)
    p = number;
  else
    p[l] = number;
}
template <class Pack>
[[gnu::always_inline]] inline void put_lane(pack_vector<Pack>& v, std::size_t l,
                                            const vector3<lane_of<Pack>>& of_lane) {
  put_lane(v.x, l, of_lane[0]), put_lane(v.y, l, of_lane[1]), put_lane(v.z, l, of_lane[2]);
}

template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline Pack dot(const pack_vector<Pack>& a,
                                                     const pack_vector<Pack>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Pack>
[[nodiscard]] [[gnu::always_inline]] inline pack_vector<Pack> crossed(const pack_vector<Pack>& a,
                                                                      const pack_vector<Pack>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Adds to the first three numbers of rows.
template <class Pack>
[[gnu::always_inline]] inline void operator+=(pack_rows<Pack>& rows, const pack_vector<Pack>& a) {
  rows.x += a.x, rows.y += a.y, rows.z += a.z;
}
template <class Pack>
[[gnu::always_inline]] inline void operator-=(pack_rows<Pack>& rows, const pack_vector<Pack>& a) {
  rows.x -= a.x, rows.y -= a.y, rows.z -= a.z;
}
template <class Real>
[[gnu::always_inline]] inline void operator+=(pack_rows<Real>& rows, const vector3<Real>& a) {
  rows.x += a[0], rows.y += a[1], rows.z += a[2];
}
template <class Real>
[[gnu::always_inline]] inline void operator-=(pack_rows<Real>& rows, const vector3<Real>& a) {
  rows.x -= a[0], rows.y -= a[1], rows.z -= a[2];
}

/// Matrices by their rows, or symmetric ones of which the upper half counts.
template <class Pack>
struct pack_matrix {
  pack_vector<Pack> x, y, z;

  [[nodiscard]] [[gnu::always_inline]] pack_vector<Pack> times(const pack_vector<Pack>& v) const {
    return {dot(x, v), dot(y, v), dot(z, v)};
  }
  /// What its transpose does to v.
  [[nodiscard]] [[gnu::always_inline]] pack_vector<Pack> across(const pack_vector<Pack>& v) const {
    return v.x * x + v.y * y + v.z * z;
  }
};

/// Symmetric matrices, by the upper halves of their rows.
template <class Pack>
struct pack_symmetric {
  Pack xx, xy, xz, yy, yz, zz;

  [[nodiscard]] [[gnu::always_inline]] pack_vector<Pack> times(const pack_vector<Pack>& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z};
  }
  [[nodiscard]] [[gnu::always_inline]] pack_vector<Pack> row_x() const { return {xx, xy, xz}; }
  [[nodiscard]] [[gnu::always_inline]] pack_vector<Pack> row_y() const { return {xy, yy, yz}; }
  [[nodiscard]] [[gnu::always_inline]] pack_vector<Pack> row_z() const { return {xz, yz, zz}; }
  [[gnu::always_inline]] void operator+=(const pack_symmetric& a) {
    xx += a.xx, xy += a.xy, xz += a.xz, yy += a.yy, yz += a.yz, zz += a.zz;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
