#pragma once
// The common normal of two surfaces. The point that a normal belongs to moves without bound where a
// surface is flat, so the points themselves are unknowns beside the normal here.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <utility>

#include "talus/core/math.hpp"
#include "talus/shape/surface_level.hpp"

namespace talus::detail {

/// All points at a distance from a corner, a line or a circle, which have no normals themselves.
template <class Real>
struct round_part {
  using vector = vector3<Real>;
  vector from, axis;  ///< a unit vector along the line or across the circle, or zero for a corner
  Real radius;
  Real circle = 0;  ///< radius of the circle about `from`, or 0

  [[nodiscard]] surface_level level(const vector& p, Real size) const {
    const vector away = p - from, across = away - axis.dot(away) * axis;
    if (circle > 0) {
      const Real wide = across.norm();
      const vector outwards = across / wide, from_circle = away - circle * outwards;
      const Real distance = from_circle.norm(), bend = size / (distance * radius);
      const vector out = from_circle / distance, around = axis.cross(outwards);
      return {distance / radius,
              (size / radius) * out,
              {{bend, bend * (wide - circle) / wide}, {out.cross(around), around}}};
    }
    const Real distance = across.norm(), bend = size / (distance * radius);
    const vector out = across / distance;
    const bool ball = !(axis.squaredNorm() > 0);
    const vector t =
        (ball ? out.cross(vector::Unit(std::abs(out[0]) < Real(0.6) ? 0 : 1)).normalized()
              : axis.cross(out));
    return {distance / radius, (size / radius) * out, {{bend, ball ? bend : 0}, {t, out.cross(t)}}};
  }
};

/// The points of two surfaces with opposite normals on one line, by Newton's method for the point
/// of a, the normal, the gap, and the lengths of the two gradients.
template <class Real, class A, class B>
class common_normal {
  using vector = vector3<Real>;

 public:
  common_normal(const A& a, Real size_a, const B& b, Real size_b, const vector& on_a,
                const vector& normal, Real gap)
      : a_(a), b_(b), size_a_(size_a), size_b_(size_b), now_{on_a, normal, gap, 0, 0} {}

  /// Whether they are found to rounding errors, within 40 steps.
  [[nodiscard]] bool find() {
    now_.of_a = a_.level(now_.on_a, size_a_).gradient.norm();
    now_.of_b = b_.level(now_.on_b(), size_b_).gradient.norm();
    residual rest = residual_of(now_);
    for (int k = 0; k < 40 && rest.size > Real(2e-15); ++k) {
      if (!solve(rest)) break;
      bool better = false;
      Real part = 1;
      for (int half = 0; half < 6 && !better; ++half, part *= Real(0.4)) {
        const unknowns next = now_.moved(part, step_);
        const residual r = residual_of(next);
        better = r.size < rest.size * (1 - Real(0.1) * part);
        if (better) now_ = next, rest = r;
      }
      if (!better) break;
    }
    return rest.size < Real(1e-12) && now_.of_a > 0 && now_.of_b > 0;
  }
  [[nodiscard]] vector normal() const { return now_.normal.normalized(); }
  [[nodiscard]] Real gap() const { return now_.gap; }
  [[nodiscard]] const vector& on_a() const { return now_.on_a; }
  /// Halfway between the two points.
  [[nodiscard]] vector middle() const { return now_.on_a - Real(0.5) * now_.gap * now_.normal; }

 private:
  static constexpr std::size_t count = 9;

  struct unknowns {
    vector on_a, normal;
    Real gap, of_a, of_b;
    [[nodiscard]] vector on_b() const { return on_a - gap * normal; }
    [[nodiscard]] unknowns moved(Real part, const std::array<Real, count>& by) const {
      return {on_a + part * vector(by[0], by[1], by[2]),
              normal + part * vector(by[3], by[4], by[5]), gap + part * by[6], of_a + part * by[7],
              of_b + part * by[8]};
    }
  };
  struct residual {
    surface_level a, b;
    std::array<Real, count> values;
    Real size;
  };

  [[nodiscard]] residual residual_of(const unknowns& x) const {
    residual r{a_.level(x.on_a, size_a_), b_.level(x.on_b(), size_b_), {}, 0};
    const vector of_a = r.a.gradient + x.of_a * x.normal, of_b = r.b.gradient - x.of_b * x.normal;
    r.values = {of_a[0],       of_a[1],       of_a[2],
                of_b[0],       of_b[1],       of_b[2],
                r.a.value - 1, r.b.value - 1, Real(0.5) * (x.normal.squaredNorm() - 1)};
    for (const Real v : r.values) r.size += v * v;
    r.size = std::sqrt(r.size);
    return r;
  }
  /// The step of Newton's method, by elimination; false if there is none.
  [[nodiscard]] bool solve(const residual& r) {
    std::array<std::array<Real, count + 1>, count> m{};
    const vector &n = now_.normal, bent = bent_by(r.b.curvature, n);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        m[i][j] = entry(r.a.curvature, i, j);
        m[3 + i][j] = entry(r.b.curvature, i, j);
        m[3 + i][3 + j] = -now_.gap * m[3 + i][j];
      }
      m[i][3 + i] += now_.of_a, m[3 + i][3 + i] -= now_.of_b;
      m[i][7] = n[at(i)], m[3 + i][6] = -bent[at(i)], m[3 + i][8] = -n[at(i)];
      m[6][i] = r.a.gradient[at(i)] / size_a_;
      m[7][i] = r.b.gradient[at(i)] / size_b_;
      m[7][3 + i] = -now_.gap * m[7][i];
      m[8][3 + i] = n[at(i)];
    }
    m[7][6] = -r.b.gradient.dot(n) / size_b_;
    // Lengths are in units of the smaller size, so that all numbers have similar magnitudes.
    const Real unit = std::min(size_a_, size_b_);
    for (std::size_t i = 0; i < count; ++i) {
      m[i][count] = -r.values[i];
      for (const std::size_t j : {0u, 1u, 2u, 6u}) m[i][j] *= unit;
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::size_t best = i;
      for (std::size_t j = i + 1; j < count; ++j)
        if (std::abs(m[j][i]) > std::abs(m[best][i])) best = j;
      if (!(std::abs(m[best][i]) > 0)) return false;
      std::swap(m[i], m[best]);
      for (std::size_t j = i + 1; j < count; ++j) {
        const Real f = m[j][i] / m[i][i];
        if (f == 0) continue;
        for (std::size_t k = i; k <= count; ++k) m[j][k] -= f * m[i][k];
      }
    }
    for (std::size_t i = count; i-- > 0;) {
      Real sum = m[i][count];
      for (std::size_t k = i + 1; k < count; ++k) sum -= m[i][k] * step_[k];
      step_[i] = sum / m[i][i];
      if (!std::isfinite(step_[i])) return false;
    }
    for (const std::size_t j : {0u, 1u, 2u, 6u}) step_[j] *= unit;
    return true;
  }
  [[nodiscard]] static std::ptrdiff_t at(std::size_t i) { return static_cast<std::ptrdiff_t>(i); }
  [[nodiscard]] static Real entry(const bending& b, std::size_t i, std::size_t j) {
    return b.factor[0] * b.along[0][at(i)] * b.along[0][at(j)] +
           b.factor[1] * b.along[1][at(i)] * b.along[1][at(j)];
  }
  [[nodiscard]] static vector bent_by(const bending& b, const vector& v) {
    return (b.factor[0] * b.along[0].dot(v)) * b.along[0] +
           (b.factor[1] * b.along[1].dot(v)) * b.along[1];
  }

  const A& a_;
  const B& b_;
  Real size_a_, size_b_;
  unknowns now_;
  std::array<Real, count> step_{};
};

}  // namespace talus::detail
