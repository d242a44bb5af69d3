#pragma once
// The normal of two ellipsoids, or of an ellipsoid and a ball: Newton's method of convex_climb.hpp
// for as many pairs as a pack has lanes. The numbers of a lane do not depend on the others.
#include "talus/core/pack.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus::detail {

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Searches the unit vector n from b to a along which the gap of both bodies is largest. A posed
/// ellipsoid is a symmetric matrix M: its support point along n is M n / sqrt(n.M n). The frame has
/// its origin in the centre of a. If `Ball`, the second body is a ball.
template <class Pack, bool Ball>
class ellipsoid_climb {
  using vector = pack_vector<Pack>;
  using mask = mask_of<Pack>;

 public:
  pack_matrix<Pack> a, b;  ///< the ellipsoids
  vector apart;            ///< from the centre of a to that of b
  Pack ball{};             ///< radius of the ball
  Pack limit;              ///< a lane ends as soon as the gap of any normal is above it
  Pack smallest;           ///< radius of a ball that is inside both bodies

  vector normal{};          ///< the best one
  vector on_a{}, on_b{};    ///< support points along it
  Pack gap{};               ///< along it; above `limit` if the lane has ended there
  mask beyond{}, summit{};  ///< the gap is above `limit`; the normal is the best of those around it

  /// Begins with a good normal: of two balls, and of ellipsoids of one form and orientation, with
  /// the best. Returns the lanes that have one and in which its gap is not above `limit`.
  mask begin() {
    const Pack one = number(1);
    vector first = start(one, one);
    // Its square has ten lengths as factors: those of tiny and huge bodies are scaled.
    const auto usual = [&] {
      const Pack squared = dot(first, first);
      return both(squared > number(1e-250), squared < number(1e250));
    };
    mask known = usual();
    if (!all_lanes(known)) {
      const Pack largest = larger(trace_of(a), Ball ? ball * ball : trace_of(b));
      const Pack away = larger(larger(size_of(apart.x), size_of(apart.y)), size_of(apart.z));
      first = choose(known, first, start(one / largest, one / away));
      known = usual();
    }
    move_to(at(unit(choose(known, first, vector{number(1), {}, {}}))), known);
    beyond = both(known, gap > limit);
    return both(known, inverted(beyond));
  }
  /// Takes 30 steps at most. A lane in which neither mask holds has found no maximum.
  void search() {
    const Pack zero{}, one = number(1), half = number(0.5);
    const Pack size = square_root(dot(apart, apart)) + smallest + ball;
    mask active = begin();
    summit = mask{};
    Pack last = number(1e300), turn = last;  // the square of the last turn
    for (int k = 0; k < 30; ++k) {
      const mask above = both(active, gap > limit);
      beyond = either(beyond, above);
      active = both(active, inverted(above));
      if (!any_lane(active)) return;
      const auto [t, u] = tangents();
      const vector w = on_a - on_b;
      const Pack rt = dot(t, w), ru = dot(u, w), rest = size_of(rt) + size_of(ru);
      const auto [aa, ab, bb] = bend(t, u);
      const auto determinant = [&](const Pack& shift) __attribute__((always_inline)) {
        return (aa + shift) * (bb + shift) - ab * ab;
      };
      // Below zero, the gap lowers the curvature of the function: away from its maximum it is
      // added.
      const Pack d = determinant(gap);
      const mask top = both(d > zero, aa + gap > zero);
      const mask sharp = either(gap >= zero, d > number(1e-3) * determinant(zero));
      const Pack shift = choose(both(top, sharp), gap, size_of(gap) + number(1e-3) * size);
      const Pack over = one / determinant(shift);
      const Pack along_t = over * ((bb + shift) * rt - ab * ru),
                 along_u = over * ((aa + shift) * ru - ab * rt);
      const Pack square = along_t * along_t + along_u * along_u;
      const mask near = rest < number(1e-10) * size;
      const mask exact = both(rest < number(1e-13) * size, square < number(1e-24));
      const mask slows = inverted(both(rest < half * last, square < turn));
      const mask ended =
          both(active, either(rest <= number(4e-16) * size, both(near, either(exact, slows))));
      summit = either(summit, both(ended, top));
      active = both(both(active, inverted(ended)), square < number(1e20));
      last = rest, turn = square;
      vector step = along_t * t + along_u * u;
      if (const mask far = square > number(0.49); any_lane(far))
        step = choose(far, number(0.7) / square_root(square), one) * step;
      const Pack enough = gap - number(1e-14) * size;  // (less is lost in rounding errors)
      const vector from = normal;
      mask trying = active;
      for (int tried = 0; tried < 8 && any_lane(trying); ++tried) {
        const points next = at(unit(from + step));
        const mask better = both(trying, next.gap >= enough);
        move_to(next, better);
        trying = both(trying, inverted(better));
        step = number(0.35) * step;
      }
      summit = either(summit, both(trying, both(near, top)));
      active = both(active, inverted(trying));
    }
  }

 private:
  struct points {
    vector normal, on_a, on_b;
    Pack gap;
    Pack over_a, over_b;  ///< one over the ways of both from their centres to there, along n
  };
  struct basis {
    vector t, u;
  };
  struct bends {
    Pack aa, ab, bb;
  };

  [[gnu::always_inline]] static Pack number(lane_of<Pack> x) { return every_lane<Pack>(x); }
  [[gnu::always_inline]] static Pack size_of(const Pack& x) { return larger(x, -x); }
  [[gnu::always_inline]] static vector unit(const vector& v) {
    return (number(1) / square_root(dot(v, v))) * v;
  }
  [[gnu::always_inline]] points at(const vector& n) const {
    const vector ma = a.times(n);
    points p{n, {}, apart, {}, {}, {}};
    if constexpr (Ball) {
      p.over_a = number(1) / square_root(dot(n, ma));
    } else {
      const vector mb = b.times(n);
      const Pack way_a = square_root(dot(n, ma)), way_b = square_root(dot(n, mb));
      const Pack over = number(1) / (way_a * way_b);
      p.over_a = over * way_b, p.over_b = over * way_a;
      p.on_b += p.over_b * mb;
    }
    p.on_a = -p.over_a * ma;
    p.gap = dot(n, p.on_a - p.on_b);
    return p;
  }
  [[gnu::always_inline]] void move_to(const points& p, const mask& where) {
    normal = choose(where, p.normal, normal);
    on_a = choose(where, p.on_a, on_a), on_b = choose(where, p.on_b, on_b);
    gap = choose(where, p.gap, gap);
    over_a_ = choose(where, p.over_a, over_a_), over_b_ = choose(where, p.over_b, over_b_);
  }
  /// Two unit vectors across the normal and each other (Duff and others, "Building an orthonormal
  /// basis, revisited", 2017).
  [[gnu::always_inline]] basis tangents() const {
    const vector& n = normal;
    const Pack one = number(1), sign = choose(n.z < Pack{}, -one, one);
    const Pack p = number(-1) / (sign + n.z), q = n.x * n.y * p;
    return {{one + sign * n.x * n.x * p, sign * q, -sign * n.x}, {q, sign + n.y * n.y * p, -n.y}};
  }
  /// Minus the derivative of the difference of both points along the tangents.
  [[gnu::always_inline]] bends bend(const vector& t, const vector& u) const {
    bends sum{};
    const auto add = [&](const pack_matrix<Pack>& m, const vector& point, const Pack& over)
        __attribute__((always_inline)) {
      const vector mt = m.times(t), mu = m.times(u);
      const Pack pt = dot(point, t), pu = dot(point, u);
      sum.aa += over * (dot(t, mt) - pt * pt);
      sum.ab += over * (dot(t, mu) - pt * pu);
      sum.bb += over * (dot(u, mu) - pu * pu);
    };
    add(a, on_a, over_a_);
    if constexpr (!Ball) add(b, on_b - apart, over_b_);
    return sum;
  }
  [[gnu::always_inline]] static Pack trace_of(const pack_matrix<Pack>& m) {
    return m.x.x + m.y.y + m.z.z;
  }
  /// Along the first normal, of matrices and a distance that are multiplied by these factors.
  [[gnu::always_inline]] vector start(const Pack& of_matrices, const Pack& of_distance) const {
    pack_matrix<Pack> s = a;
    if constexpr (Ball)
      s.x.x += ball * ball, s.y.y += ball * ball, s.z.z += ball * ball;
    else
      s.x += b.x, s.y += b.y, s.z += b.z;
    s.x = of_matrices * s.x, s.y = of_matrices * s.y, s.z = of_matrices * s.z;
    const vector d = of_distance * apart;
    // The direction of the inverse of s times the distance, by the cofactors of s.
    return {-dot(crossed(s.y, s.z), d), -dot(crossed(s.z, s.x), d), -dot(crossed(s.x, s.y), d)};
  }

  Pack over_a_{}, over_b_{};  ///< see points
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
