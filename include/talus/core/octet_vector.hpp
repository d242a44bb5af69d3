#pragma once
// Vectors and matrices of eight things at once.
#include "talus/core/octet.hpp"

namespace talus::detail {

// As with octets, everything here is inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Three components of eight things.
struct octet_vector {
  octet x, y, z;

  [[gnu::always_inline]] friend octet_vector operator+(const octet_vector& a,
                                                       const octet_vector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  [[gnu::always_inline]] friend octet_vector operator-(const octet_vector& a,
                                                       const octet_vector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  [[gnu::always_inline]] friend octet_vector operator*(const octet& s, const octet_vector& a) {
    return {s * a.x, s * a.y, s * a.z};
  }
  [[gnu::always_inline]] void operator+=(const octet_vector& a) { x += a.x, y += a.y, z += a.z; }
};
[[nodiscard]] [[gnu::always_inline]] inline octet dot(const octet_vector& a,
                                                      const octet_vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[nodiscard]] [[gnu::always_inline]] inline octet_vector crossed(const octet_vector& a,
                                                                 const octet_vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Eight matrices by their rows, or symmetric ones of which the upper half counts.
struct octet_matrix {
  octet_vector x, y, z;

  [[nodiscard]] [[gnu::always_inline]] octet_vector times(const octet_vector& v) const {
    return {dot(x, v), dot(y, v), dot(z, v)};
  }
  /// What its transpose does to v.
  [[nodiscard]] [[gnu::always_inline]] octet_vector across(const octet_vector& v) const {
    return v.x * x + v.y * y + v.z * z;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
