#pragma once
// The contact points of a convex body on the triangles of one plane, as those of a single face.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "talus/contact/contact_geometry.hpp"
#include "talus/core/math.hpp"
#include "talus/detect/detail/convex_patch.hpp"
#include "talus/shape/weld_triangles.hpp"

namespace talus::detail {

/// Collects the contact points of triangles, and gives those of each plane that span their convex
/// hull, at most 16: how a plane is divided into triangles has no effect on a body that rests on
/// it, nor on the stiffness of soft contacts.
class level_patches {
 public:
  /// Patches for a body of this size on a surface with this radius. Corners may deviate from a
  /// plane by the round-off of single precision.
  level_patches(real size, real radius)
      : near_(real(1e-6) * size),
        off_(near_ + weld_part * radius),
        tilted_(std::min(off_ / size, real(0.01))) {}

  /// A contact of a triangle: `up` is the normal of its plane on the side of the body, and `level`
  /// the height of the plane along it over the centre of the body. A contact that is `cut` is where
  /// the triangle ends and its plane does not; it counts only in a plane that has no others.
  /// Returns false if there is no room.
  bool add(const contact_geometry& c, const vec3& up, real level, bool cut = false) {
    std::size_t k = 0;
    while (k < size_ && !(std::abs(patches_[k].level - level) <= off_ &&
                          (patches_[k].up - up).squaredNorm() <= tilted_ * tilted_))
      ++k;
    if (k == patches_.size()) return false;
    patch& p = patches_[k];
    if (k == size_) {
      ++size_;
      p.up = up, p.level = level, p.size = 0, p.cut = cut;
      p.u = vec3::Unit(std::abs(up[0]) < real(0.6) ? 0 : 1).cross(up).normalized();
      p.v = up.cross(p.u);
    }
    if (cut && !p.cut) return true;
    if (p.cut && !cut) p.size = 0, p.cut = false;
    if (p.size == p.points.size()) reduce(p, 0);
    if (p.size == p.points.size()) return false;
    p.contacts[p.size] = c;
    p.points[p.size] = {p.u.dot(c.point), p.v.dot(c.point), c.gap, 0, 0, c.point};
    ++p.size;
    return true;
  }
  /// Calls sink(contact) for the points that are kept.
  template <class Sink>
  void each(Sink&& sink) {
    for (std::size_t k = 0; k < size_; ++k) {
      reduce(patches_[k], near_);
      for (std::size_t n = 0; n < patches_[k].size; ++n) sink(patches_[k].contacts[n]);
    }
  }

 private:
  static constexpr std::size_t capacity = 48, most_planes = 4;
  using point = patch_point<real>;
  struct patch {
    vec3 up, u, v;
    real level;
    std::size_t size;
    bool cut;  ///< all its contacts are
    std::array<point, capacity> points;
    std::array<contact_geometry, capacity> contacts;
  };

  /// Keeps the corners of the convex hull (Andrew 1979), and of these an outline, if `tolerance` is
  /// positive.
  void reduce(patch& p, real tolerance) const {
    if (p.size < 2) return;
    for (std::size_t k = 0; k < p.size; ++k) p.points[k].reference = static_cast<part_code>(k);
    std::array<point, capacity> sorted;
    const auto end = std::copy_n(p.points.begin(), p.size, sorted.begin());
    const auto sort = [&] {
      std::sort(sorted.begin(), end, [](const point& a, const point& b) {
        return a.u != b.u ? a.u < b.u : a.v != b.v ? a.v < b.v : a.reference < b.reference;
      });
    };
    sort();
    // Points on a line of constant u follow each other along it, although round-off parts them.
    for (auto from = sorted.begin(), k = from; k != end; ++k)
      k->u - from->u <= near_ ? void(k->u = from->u) : void(from = k);
    sort();
    std::array<point, 2 * capacity> hull;
    std::size_t size = 0;
    const auto turn = [&](auto from, auto to, std::size_t least) {
      for (; from != to; ++from) {
        if (size > 0 && same(hull[size - 1], *from)) continue;
        while (size >= least && !left(hull[size - 2], hull[size - 1], *from)) --size;
        hull[size++] = *from;
      }
    };
    turn(sorted.begin(), end, 2);
    const std::size_t lower = size;
    turn(std::make_reverse_iterator(end), std::make_reverse_iterator(sorted.begin()), lower + 1);
    if (size > 1 && same(hull[0], hull[size - 1])) --size;
    if (tolerance > 0)
      size = static_cast<std::size_t>(keep_outline(hull.data(), static_cast<int>(size), tolerance));
    std::array<contact_geometry, capacity> kept;
    for (std::size_t k = 0; k < size; ++k)
      kept[k] = p.contacts[hull[k].reference], p.points[k] = hull[k];
    std::copy_n(kept.begin(), size, p.contacts.begin());
    p.size = size;
  }
  [[nodiscard]] bool same(const point& a, const point& b) const {
    return std::abs(a.u - b.u) <= near_ && std::abs(a.v - b.v) <= near_;
  }
  /// Whether b lies to the right of the line from a to c, by more than the tolerance.
  [[nodiscard]] bool left(const point& a, const point& b, const point& c) const {
    const real x = c.u - a.u, y = c.v - a.v;
    return x * (b.v - a.v) - y * (b.u - a.u) < -near_ * std::sqrt(x * x + y * y);
  }

  real near_;          ///< of points, which are one
  real off_, tilted_;  ///< of triangles in one plane: their heights, and the angle between them
  std::size_t size_ = 0;
  std::array<patch, most_planes> patches_;
};

}  // namespace talus::detail
