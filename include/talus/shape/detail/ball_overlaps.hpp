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

/// Area and moments between circles in a plane.
template <class Real>
struct plane_moments {
  Real one = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;

  /// Adds the boundary integrals, by Green, of an arc about (a, b) from one angle to another.
  void add_arc(Real a, Real b, Real r, Real from, Real to) {
    const auto at = [](Real t) {
      const auto [s, c] = portable::sincos(t);
      const Real s2 = 2 * s * c, s4 = 2 * s2 * (c * c - s * s);
      return std::array<Real, 9>{s,
                                 t / 2 + s2 / 4,
                                 s - s * s * s / 3,
                                 3 * t / 8 + s2 / 4 + s4 / 32,
                                 s * s / 2,
                                 -c * c * c / 3,
                                 -c * c * c * c / 4,
                                 s * s * s / 3,
                                 t / 8 - s4 / 32};
    };
    std::array<Real, 9> f = at(to);
    const std::array<Real, 9> low = at(from);
    for (std::size_t k = 0; k < f.size(); ++k) f[k] = r * (f[k] - low[k]);
    // Integrals of c, c², c³, c⁴, cs, c²s, c³s, cs², c²s² over the arc, times r.
    const auto [c1, c2, c3, c4, cs, c2s, c3s, cs2, c2s2] = f;
    const Real r2 = r * r, r3 = r2 * r;
    one += a * c1 + r * c2;
    x += (a * a * c1 + 2 * a * r * c2 + r2 * c3) / 2;
    y += a * b * c1 + a * r * cs + b * r * c2 + r2 * c2s;
    xx += (a * a * a * c1 + 3 * a * a * r * c2 + 3 * a * r2 * c3 + r3 * c4) / 3;
    xy += (a * a * b * c1 + a * a * r * cs + 2 * a * b * r * c2 + 2 * a * r2 * c2s + b * r2 * c3 +
           r3 * c3s) /
          2;
    yy += a * b * b * c1 + 2 * a * b * r * cs + a * r2 * cs2 + b * b * r * c2 + 2 * b * r2 * c2s +
          r3 * c2s2;
  }
};

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
  };
  struct span {
    Real from, to;
  };

  /// Heights at which the circles change: of poles, of the ends of circles in which two balls meet,
  /// and of points in which three do. Heights and places are those from the centre of the ball.
  void find_slabs() {
    std::vector<part_ball<Real>> all{{{0, 0, 0}, one_.radius}};
    for (const part_ball<Real>& o : others_) all.push_back({o.centre - one_.centre, o.radius});
    const Real r = one_.radius;
    slabs_ = {-r, r};
    const auto add = [&](Real z) {
      if (z > -r && z < r) slabs_.push_back(z);
    };
    for (std::size_t i = 0; i < all.size(); ++i) {
      const part_ball<Real>& a = all[i];
      add(a.centre[2] - a.radius), add(a.centre[2] + a.radius);
      for (std::size_t j = 0; j < i; ++j) {
        const part_ball<Real>& b = all[j];
        const vector3<Real> way = b.centre - a.centre;
        const Real d = way.norm();
        if (!(d > 0)) continue;
        const Real from_a = (d * d + (a.radius - b.radius) * (a.radius + b.radius)) / (2 * d);
        const Real square = (a.radius - from_a) * (a.radius + from_a);
        if (!(square > 0)) continue;
        const vector3<Real> axis = way / d, middle = a.centre + from_a * axis;
        const Real ring = std::sqrt(square);
        const Real rise = ring * std::sqrt(std::max(Real(0), 1 - axis[2] * axis[2]));
        add(middle[2] - rise), add(middle[2] + rise);
        for (std::size_t k = 0; k < j; ++k) {
          // The circle meets the third ball where its plane cuts that of the circle.
          const part_ball<Real>& c = all[k];
          const vector3<Real> to = c.centre - middle;
          const vector3<Real> flat = to - axis.dot(to) * axis;
          const Real far = flat.norm();
          if (!(far > Real(1e-14) * ring)) continue;
          const Real along = (to.squaredNorm() + square - c.radius * c.radius) / (2 * far);
          const Real left = (ring - along) * (ring + along);
          if (!(left > 0)) continue;
          const vector3<Real> e = flat / far;
          const Real height = middle[2] + along * e[2], half = std::sqrt(left) * axis.cross(e)[2];
          add(height - half), add(height + half);
        }
      }
    }
    std::sort(slabs_.begin(), slabs_.end());
    std::size_t kept = 0;
    for (const Real z : slabs_)
      if (kept == 0 || z - slabs_[kept - 1] > Real(1e-12) * r) slabs_[kept++] = z;
    slabs_.resize(kept);
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
    for (std::size_t k = 0; k < nodes.size(); ++k)
      for (const Real side : {Real(-1), Real(1)}) {
        // The heights lie close at the ends, where lengths grow as square roots.
        const auto [s, c] = portable::sincos(Real(pi) / 2 * side * nodes[k]);
        add_slice(middle + half * s, Real(pi) / 2 * half * c * weights[k], sum);
      }
  }
  void add_slice(Real z, Real weight, mass_moments<Real>& sum) {
    circles_.clear();
    const auto put = [&](const vector3<Real>& centre, Real radius) {
      const Real square = (radius - (z - centre[2])) * (radius + (z - centre[2]));
      if (square > 0) circles_.push_back({centre[0], centre[1], std::sqrt(square)});
      return square > 0;
    };
    if (!put({0, 0, 0}, one_.radius)) return;
    for (const part_ball<Real>& o : others_) put(o.centre - one_.centre, o.radius);
    plane_moments<Real> m;
    // The boundary of the part of circle 0 inside others: its own arcs inside one of them, and
    // their arcs inside it and outside each other.
    for (std::size_t i = 0; i < circles_.size(); ++i) {
      covered_.clear();
      bool gone = false;
      for (std::size_t j = 0; j < circles_.size() && !gone; ++j)
        if (j != i) gone = cover(circles_[i], circles_[j], i > 0 && j == 0);
      const circle& c = circles_[i];
      std::sort(covered_.begin(), covered_.end(),
                [](const span& a, const span& b) { return a.from < b.from; });
      Real at = 0;
      const auto free = [&](Real from, Real to) {
        if (i > 0 && to > from) m.add_arc(c.x, c.y, c.r, from, to);
      };
      const auto shut = [&](Real from, Real to) {
        if (i == 0 && to > from) m.add_arc(c.x, c.y, c.r, from, to);
      };
      if (gone) {
        shut(0, 2 * Real(pi));
        continue;
      }
      for (const span& s : covered_) {
        free(at, s.from);
        shut(std::max(at, s.from), s.to);
        at = std::max(at, s.to);
      }
      free(at, 2 * Real(pi));
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

  part_ball<Real> one_;
  std::vector<part_ball<Real>> others_;
  std::vector<Real> slabs_;
  std::vector<circle> circles_;
  std::vector<span> covered_;
};

}  // namespace talus::detail
