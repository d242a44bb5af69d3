#pragma once
// Volume and moments of what a ball shares with other balls: closed forms for one other ball, else
// slabs, whose areas between circles are exact. Gauss's rule over the slabs between all places at
// which circles appear, touch or meet in threes converges fast.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/detail/plane_moments.hpp"
#include "talus/shape/principal_axes.hpp"

namespace talus::detail {

template <class Real>
struct part_ball {
  vector3<Real> centre;
  Real radius;
};

template <class Real>
[[nodiscard]] bool balls_meet(const part_ball<Real>& a, const part_ball<Real>& b) {
  const Real reach = a.radius + b.radius;
  return (a.centre - b.centre).squaredNorm() < reach * reach * (1 - Real(1e-12));
}
template <class Real>
[[nodiscard]] bool ball_contains(const part_ball<Real>& outer, const part_ball<Real>& inner) {
  return (outer.centre - inner.centre).norm() + inner.radius <= outer.radius * (1 + Real(1e-13));
}

/// What two balls share, in closed form: two caps with one base. Moments about the origin.
template <class Real>
[[nodiscard]] mass_moments<Real> shared_by_two(const part_ball<Real>& a, const part_ball<Real>& b) {
  mass_moments<Real> sum;
  if (!balls_meet(a, b)) return sum;
  const vector3<Real> way = b.centre - a.centre;
  const Real distance = way.norm();
  const auto add = [&](const part_ball<Real>& of, const vector3<Real>& along, Real from) {
    // The cap of points x >= from along the axis.
    const Real r = of.radius, r2 = r * r;
    const auto between = [&](auto&& f) { return Real(pi) * (f(r) - f(from)); };
    const Real mass = between([&](Real x) { return x * (r2 - x * x / 3); });
    const Real first = between([&](Real x) { return x * x * (r2 / 2 - x * x / 4); });
    const Real axial = between([&](Real x) { return x * x * x * (r2 / 3 - x * x / 5); });
    const Real across =
        between([&](Real x) { return x * (r2 * r2 - x * x * (2 * r2 / 3 - x * x / 5)) / 4; });
    const vector3<Real>& c = of.centre;
    sum.mass += mass;
    sum.first += mass * c + first * along;
    sum.second += mass * outer(c, c) + first * (outer(c, along) + outer(along, c)) +
                  (axial - across) * outer(along, along) + diagonal_matrix<Real>(across);
  };
  if (ball_contains(a, b) || ball_contains(b, a)) {
    const part_ball<Real>& inner = a.radius < b.radius ? a : b;
    add(inner, {1, 0, 0}, -inner.radius);
    return sum;
  }
  const vector3<Real> axis = way / distance;
  const Real plane =
      (distance * distance + (a.radius - b.radius) * (a.radius + b.radius)) / (2 * distance);
  add(a, axis, plane);
  add(b, -axis, distance - plane);
  return sum;
}

/// What a ball shares with the union of others that meet it. Moments about the origin.
template <class Real>
class shared_by_many {
 public:
  shared_by_many(const part_ball<Real>& one, const std::vector<part_ball<Real>>& others)
      : one_(one) {
    for (const part_ball<Real>& o : others) {
      if (!balls_meet(one, o)) continue;
      bool inside = false;
      for (const part_ball<Real>& k : others_) inside = inside || ball_contains(k, o);
      if (inside) continue;
      std::erase_if(others_, [&](const part_ball<Real>& k) { return ball_contains(o, k); });
      others_.push_back(o);
    }
  }
  /// Number of slabs that moments() has integrated.
  [[nodiscard]] std::size_t slabs() const { return slabs_.empty() ? 0 : slabs_.size() - 1; }
  [[nodiscard]] mass_moments<Real> moments() {
    bool apart = true;
    for (std::size_t i = 0; i < others_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) apart = apart && !balls_meet(others_[i], others_[j]);
    mass_moments<Real> sum;
    if (apart) {
      for (const part_ball<Real>& o : others_) sum += shared_by_two(one_, o);
      return sum;
    }
    for (const part_ball<Real>& o : others_)
      if (ball_contains(o, one_)) return shared_by_two(one_, o);
    find_slabs();
    for (std::size_t k = 0; k + 1 < slabs_.size(); ++k) integrate(slabs_[k], slabs_[k + 1], sum);
    // From moments about the centre of the ball to those about the origin.
    const vector3<Real>& c = one_.centre;
    sum.second += outer(c, sum.first) + outer(sum.first, c) + sum.mass * outer(c, c);
    sum.first += sum.mass * c;
    return sum;
  }

 private:
  struct circle {
    Real x, y, r;
    std::size_t ball;  ///< in `all_`
  };
  struct span {
    Real from, to;
  };

  /// Heights at which the boundary of what is shared changes in the slices: of poles, of the ends
  /// of circles in which two balls meet, and of points in which three do, as far as these lie in
  /// the ball and in no other one. Heights and places are those from the centre of the ball.
  void find_slabs() {
    all_.assign(1, {{0, 0, 0}, one_.radius});
    for (const part_ball<Real>& o : others_) all_.push_back({o.centre - one_.centre, o.radius});
    slabs_ = {-one_.radius, one_.radius};
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const part_ball<Real>& a = all_[i];
      for (const Real side : {Real(-1), Real(1)})
        add_height(a.centre + vector3<Real>(0, 0, side * a.radius), i, i, i);
      for (std::size_t j = 0; j < i; ++j) add_heights_of_two(i, j);
    }
    std::sort(slabs_.begin(), slabs_.end());
    std::size_t kept = 0;
    for (const Real z : slabs_)
      if (kept == 0 || z - slabs_[kept - 1] > Real(1e-12) * one_.radius) slabs_[kept++] = z;
    slabs_.resize(kept);
  }
  /// Adds the height of a point of the surfaces of balls i, j and k.
  void add_height(const vector3<Real>& p, std::size_t i, std::size_t j, std::size_t k) {
    const Real r = one_.radius;
    if (!(std::abs(p[2]) < r && p.squaredNorm() <= r * r * (1 + doubt))) return;
    for (std::size_t n = 1; n < all_.size(); ++n)
      if (n != i && n != j && n != k &&
          (p - all_[n].centre).squaredNorm() < all_[n].radius * all_[n].radius * (1 - doubt))
        return;
    slabs_.push_back(p[2]);
  }
  /// Adds the heights of the circle in which the surfaces of two balls meet, and of its points in a
  /// third one.
  void add_heights_of_two(std::size_t i, std::size_t j) {
    const part_ball<Real>&a = all_[i], &b = all_[j];
    const vector3<Real> way = b.centre - a.centre;
    const Real d = way.norm();
    if (!(d > 0)) return;
    const Real from_a = (d * d + (a.radius - b.radius) * (a.radius + b.radius)) / (2 * d);
    const Real square = (a.radius - from_a) * (a.radius + from_a);
    if (!(square > 0)) return;
    const vector3<Real> axis = way / d, middle = a.centre + from_a * axis;
    const Real ring = std::sqrt(square);
    for (std::size_t n = 1; n < all_.size(); ++n) {
      if (n == i || n == j) continue;
      const vector3<Real> to = all_[n].centre - middle;
      const Real beside = axis.dot(to), away = vector3<Real>(to - beside * axis).norm() + ring;
      if (away * away + beside * beside < all_[n].radius * all_[n].radius * (1 - doubt)) return;
    }
    const Real steep = std::sqrt(std::max(Real(0), 1 - axis[2] * axis[2]));
    if (steep > Real(1e-12)) {
      const vector3<Real> up = (vector3<Real>(0, 0, 1) - axis[2] * axis) * (ring / steep);
      add_height(middle - up, i, j, j), add_height(middle + up, i, j, j);
    } else if (std::abs(middle[2]) < one_.radius) {
      slabs_.push_back(middle[2]);
    }
    for (std::size_t k = 0; k < j; ++k) {
      // The circle meets the third ball where its plane cuts that of the circle.
      const part_ball<Real>& c = all_[k];
      const vector3<Real> to = c.centre - middle;
      const vector3<Real> flat = to - axis.dot(to) * axis;
      const Real far = flat.norm();
      if (!(far > Real(1e-14) * ring)) continue;
      const Real along = (to.squaredNorm() + square - c.radius * c.radius) / (2 * far);
      const Real left = (ring - along) * (ring + along);
      if (!(left > 0)) continue;
      const vector3<Real> e = flat / far, foot = middle + along * e;
      const vector3<Real> aside = axis.cross(e) * std::sqrt(left);
      add_height(foot - aside, i, j, k), add_height(foot + aside, i, j, k);
    }
  }
  void integrate(Real low, Real high, mass_moments<Real>& sum) {
    // Nodes and weights of 16 points on (-1, 1), by symmetry half of them.
    static constexpr std::array<Real, 8> nodes{
        Real(0.0950125098376374402), Real(0.2816035507792589132), Real(0.4580167776572273863),
        Real(0.6178762444026437484), Real(0.7554044083550030339), Real(0.8656312023878317439),
        Real(0.9445750230732325761), Real(0.9894009349916499326)};
    static constexpr std::array<Real, 8> weights{
        Real(0.1894506104550684963), Real(0.1826034150449235889), Real(0.1691565193950025382),
        Real(0.1495959888165767321), Real(0.1246289712555338720), Real(0.0951585116824927848),
        Real(0.0622535239386478929), Real(0.0271524594117540949)};
    const Real middle = (low + high) / 2, half = (high - low) / 2;
    // A circle that is inside others in one slice of a slab is so in all.
    hidden_.assign(all_.size(), false);
    hidden_are_known_ = false;
    for (std::size_t k = 0; k < nodes.size(); ++k)
      for (const Real side : {Real(-1), Real(1)}) {
        // The heights lie close at the ends, where lengths grow as square roots.
        const auto [s, c] = portable::sincos(Real(pi) / 2 * side * nodes[k]);
        add_slice(middle + half * s, Real(pi) / 2 * half * c * weights[k], sum);
        hidden_are_known_ = true;
      }
  }
  void add_slice(Real z, Real weight, mass_moments<Real>& sum) {
    circles_.clear();
    for (std::size_t n = 0; n < all_.size(); ++n) {
      const auto& [centre, radius] = all_[n];
      const Real square = (radius - (z - centre[2])) * (radius + (z - centre[2]));
      if (square > 0)
        circles_.push_back({centre[0], centre[1], std::sqrt(square), n});
      else if (n == 0)
        return;
    }
    plane_moments<Real> m;
    // The boundary of the part of circle 0 inside others: its own arcs inside one of them, and
    // their arcs inside it and outside each other.
    for (std::size_t i = 0; i < circles_.size(); ++i) {
      if (hidden_[circles_[i].ball]) continue;
      covered_.clear();
      bool gone = false, seen = i == 0;
      for (std::size_t j = 0; j < circles_.size() && !gone; ++j)
        if (j != i) gone = cover(circles_[i], circles_[j], i > 0 && j == 0);
      const circle& c = circles_[i];
      std::sort(covered_.begin(), covered_.end(),
                [](const span& a, const span& b) { return a.from < b.from; });
      Real at = 0;
      const auto free = [&](Real from, Real to) {
        if (i > 0 && to > from) m.add_arc(c.x, c.y, c.r, from, to), seen = true;
      };
      const auto shut = [&](Real from, Real to) {
        if (i == 0 && to > from) m.add_arc(c.x, c.y, c.r, from, to);
      };
      if (gone) {
        shut(0, 2 * Real(pi));
        if (!hidden_are_known_) hidden_[c.ball] = !seen;
        continue;
      }
      for (const span& s : covered_) {
        free(at, s.from);
        shut(std::max(at, s.from), s.to);
        at = std::max(at, s.to);
      }
      free(at, 2 * Real(pi));
      if (!hidden_are_known_) hidden_[c.ball] = !seen;
    }
    sum.mass += weight * m.one;
    sum.first += weight * vector3<Real>(m.x, m.y, z * m.one);
    const Real xz = z * m.x, yz = z * m.y;
    sum.second += weight * matrix3<Real>(m.xx, m.xy, xz, m.xy, m.yy, yz, xz, yz, z * z * m.one);
  }
  /// Covers the arc of p inside q, or that outside; returns whether it covers all of p.
  [[nodiscard]] bool cover(const circle& p, const circle& q, bool outside) {
    const Real x = q.x - p.x, y = q.y - p.y, d2 = x * x + y * y, d = std::sqrt(d2);
    const Real above = d2 + (p.r - q.r) * (p.r + q.r), below = 2 * d * p.r;
    if (above >= below) return outside;    // p is outside of q
    if (above <= -below) return !outside;  // p is inside of q
    const Real half = portable::acos(above / below), middle = portable::atan2(y, x);
    Real from = outside ? middle + half : middle - half;
    const Real wide = outside ? 2 * (Real(pi) - half) : 2 * half;
    if (from < 0) from += 2 * Real(pi);
    const Real to = from + wide;
    if (to > 2 * Real(pi)) {
      covered_.push_back({from, 2 * Real(pi)});
      covered_.push_back({0, to - 2 * Real(pi)});
    } else {
      covered_.push_back({from, to});
    }
    return false;
  }

  /// Relative; a height too many does no harm.
  static constexpr Real doubt = Real(1e-9);

  part_ball<Real> one_;
  std::vector<part_ball<Real>> others_;
  std::vector<part_ball<Real>> all_;  ///< the ball, then the others, from its centre
  std::vector<bool> hidden_;          ///< of all: no part of its circle is seen in this slab
  bool hidden_are_known_ = false;
  std::vector<Real> slabs_;
  std::vector<circle> circles_;
  std::vector<span> covered_;
};

}  // namespace talus::detail
