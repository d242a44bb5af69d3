#pragma once
// The half-space, from which all domain geometry is made.
#include <compare>
#include <cstdint>
#include <string>
#include <type_traits>

#include "talus/concepts.hpp"
#include "talus/core/error.hpp"

namespace talus {

namespace detail {

/// A product rounded to a real, never fused into an addition, so that a sum of products has the
/// same bits in every inlining or constant folding: all ranks must have the same boundary.
constexpr real rounded(real product) {
#if defined(__FMA__) && defined(__x86_64__)
  if (!std::is_constant_evaluated()) asm("" : "+x"(product));
#elif defined(__aarch64__)
  if (!std::is_constant_evaluated()) asm("" : "+w"(product));
#endif
  return product;
}

constexpr real magnitude(real x) { return x < 0 ? -x : x; }

/// The square root of a number in [1, 4), with the same bits at compile time, where not all
/// compilers support std::sqrt: computed there as that of an integer of 106 bits.
constexpr real root(real x) {
  if (!std::is_constant_evaluated()) return __builtin_sqrt(x);
  __extension__ using whole = unsigned __int128;
  constexpr real units = 4503599627370496;  // 2^52 of them in 1
  const whole square = static_cast<whole>(x * units) << 52;
  whole r = whole{1} << 53;
  for (whole next = r; (next = (r + square / r) / 2) < r;) r = next;
  if (square - r * r > r) ++r;  // nearer to the next one
  return static_cast<real>(static_cast<std::uint64_t>(r)) / units;
}

}  // namespace detail

/// All points x with n·x >= d, for a unit normal n that points into the half-space. A normal given
/// with another length is normalised; the displacement d (a length) stays. Reversing all signs
/// yields the other side, with exactly the negative value at every point, to the last bit. Throws
/// invalid_argument for a normal of length zero and for anything not finite.
class half_space {
 public:
  /// Normal (a, b, c) and displacement d from the origin.
  constexpr half_space(real a, real b, real c, real d) : a_(a), b_(b), c_(c), d_(d) {
    normalize();
    check();
  }
  /// Normal (a, b, c) and a point (x, y, z) of the boundary.
  constexpr half_space(real a, real b, real c, real x, real y, real z)
      : a_(a), b_(b), c_(c), d_(0) {
    normalize();
    d_ = value(x, y, z) + 0.0;
    check();
  }
  half_space(const vec3& normal, real displacement)
      : half_space(normal[0], normal[1], normal[2], displacement) {}
  half_space(const vec3& normal, const vec3& point)
      : half_space(normal[0], normal[1], normal[2], point[0], point[1], point[2]) {}

  /// Signed distance to the boundary, positive inside.
  [[nodiscard]] constexpr real value(real x, real y, real z) const {
    return detail::rounded(a_ * x) + detail::rounded(b_ * y) + detail::rounded(c_ * z) - d_;
  }
  [[nodiscard]] real value(const vec3& p) const { return value(p[0], p[1], p[2]); }
  [[nodiscard]] bool contains(const vec3& p) const { return value(p) >= 0; }
  /// Whether it contains the point, where the boundary belongs only to the side towards +x (then
  /// +y, then +z).
  [[nodiscard]] bool owns(const vec3& p) const {
    const real v = value(p);
    return v > 0 || (v == 0 && faces_up());
  }

  [[nodiscard]] vec3 normal() const { return {a_, b_, c_}; }
  [[nodiscard]] constexpr real displacement() const { return d_; }
  /// The other side of the same plane.
  [[nodiscard]] constexpr half_space flipped() const {
    half_space h = *this;
    h.a_ = 0 - a_, h.b_ = 0 - b_, h.c_ = 0 - c_, h.d_ = 0 - d_;
    return h;
  }
  /// Whether the first component of the normal that is not zero is positive.
  [[nodiscard]] constexpr bool faces_up() const {
    return a_ != 0 ? a_ > 0 : b_ != 0 ? b_ > 0 : c_ > 0;
  }

  friend constexpr auto operator<=>(const half_space&, const half_space&) = default;

  template <class Sink>
  void describe(Sink& sink) const {
    sink.plane(*this);
  }

 private:
  constexpr void normalize() {
    const real ma = detail::magnitude(a_), mb = detail::magnitude(b_), mc = detail::magnitude(c_);
    const real largest = ma > mb ? (ma > mc ? ma : mc) : (mb > mc ? mb : mc);
    if (!(largest > 0) || !(ma <= max_ && mb <= max_ && mc <= max_)) refuse_normal();
    // A normal that is unit up to round-off keeps its bits: normalising twice changes nothing.
    if (detail::magnitude(square() - 1) > 1e-15) {
      scale(largest);  // first, so that multiples of one normal end up equal to the bit
      scale(detail::root(square()));
    }
    a_ += 0.0, b_ += 0.0, c_ += 0.0, d_ += 0.0;  // -0 becomes 0: equal planes have equal bits
  }
  [[nodiscard]] constexpr real square() const {
    return detail::rounded(a_ * a_) + detail::rounded(b_ * b_) + detail::rounded(c_ * c_);
  }
  constexpr void scale(real length) { a_ /= length, b_ /= length, c_ /= length; }
  constexpr void check() const {
    if (!(detail::magnitude(d_) <= max_)) refuse_displacement();
  }
  [[noreturn]] void refuse_normal() const {
    detail::fail<std::invalid_argument>(
        "the normal ({}, {}, {}) of a half-space must be finite and not zero; "
        "give the direction from the plane into the half-space",
        a_, b_, c_);
  }
  [[noreturn]] void refuse_displacement() const {
    detail::fail<std::invalid_argument>(
        "the plane of a half-space with the normal ({}, {}, {}) must lie at a finite displacement, "
        "but it is {}; give a finite displacement or point",
        a_, b_, c_, d_);
  }

  static constexpr real max_ = 1.7976931348623157e308;
  real a_, b_, c_, d_;
};

/// A half-space as a condition, with all digits: "x >= 2", "0.6 x - 0.8 z >= 1".
[[nodiscard]] inline std::string to_string(const half_space& h) {
  const vec3 n = h.normal();
  std::string text;
  for (int i = 0; i < 3; ++i) {
    if (n[i] == 0) continue;
    const real size = detail::magnitude(n[i]);
    text += text.empty() ? (n[i] < 0 ? "-" : "") : (n[i] < 0 ? " - " : " + ");
    if (size != 1) text += detail::text(size) + " ";
    text += "xyz"[i];
  }
  return text + " >= " + detail::text(h.displacement());
}

}  // namespace talus
