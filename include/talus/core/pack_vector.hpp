#pragma once
// Vectors and matrices of several things at once.
#include "talus/core/pack.hpp"

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
};
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

#pragma GCC diagnostic pop

}  // namespace talus::detail
