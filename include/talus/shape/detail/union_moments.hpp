#pragma once
// Mass, centre and inertia of a union: those of the parts, less what parts share.
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <variant>
#include <vector>

#include "talus/core/math.hpp"
#include "talus/shape/detail/ball_overlaps.hpp"
#include "talus/shape/detail/part_overlaps.hpp"
#include "talus/shape/detail/solid_overlaps.hpp"
#include "talus/shape/detail/support_chord.hpp"
#include "talus/shape/detail/union_parts.hpp"
#include "talus/shape/frame.hpp"
#include "talus/shape/principal_axes.hpp"
#include "talus/shape/sphere.hpp"

namespace talus::detail {

/// Moments of a shape at a pose about the origin, for the given density.
template <class Real, class Shape>
[[nodiscard]] mass_moments<Real> moments_of(const Shape& shape, const pose& at, Real density) {
  const Real mass = density * shape.volume();
  const vec3 centre = at.position, i = shape.inertia();
  const vec3 spread(i[1] + i[2] - i[0], i[2] + i[0] - i[1], i[0] + i[1] - i[2]);
  const matrix3<Real> turn = at.orientation.toRotationMatrix();
  matrix3<Real> own = diagonal_matrix<Real>(0);
  for (int k = 0; k < 3; ++k) own(k, k) = 0.5 * spread[k];
  return {mass, mass * centre, mass * (turn * own * turn.transpose() + outer(centre, centre))};
}

/// What each part shares with parts of a larger density, or of the same one before it. What several
/// parts share thus counts once, with the largest density.
template <class Real, class... Shapes>
class shared_moments {
  using parts_type = union_parts<Shapes...>;
  static constexpr bool only_spheres = (... && std::is_same_v<Shapes, sphere>);
  /// For parts whose chords are found by a search, which may take microseconds each.
  static constexpr line_budget searched{1e-6, 1000000};

 public:
  /// The parts, sorted, at their places.
  explicit shared_moments(const parts_type& parts) : parts_(parts) {
    const std::size_t n = parts.entries.size();
    density_.resize(n), order_.resize(n), is_ball_.resize(n), is_flat_.resize(n);
    for (std::size_t i = 0; i < n; ++i)
      parts.visit(i, [&]<class Shape>(const Shape&, const pose&, real density) {
        density_[i] = density;
        is_ball_[i] = std::is_same_v<Shape, sphere>;
        is_flat_[i] = is_flat_solid<Shape>;
      });
    std::vector<std::uint32_t> by_density(n);
    std::iota(by_density.begin(), by_density.end(), 0u);
    std::stable_sort(by_density.begin(), by_density.end(),
                     [&](auto a, auto b) { return density_[a] > density_[b]; });
    for (std::uint32_t k = 0; k < n; ++k) order_[by_density[k]] = k;
  }
  /// Subtracts what parts share from the sum over all parts; returns whether they share anything.
  [[nodiscard]] bool subtract_from(mass_moments<Real>& sum) {
    bool any = false;
    for (std::size_t i = 0; i < density_.size(); ++i) {
      if (density_[i] == 0) continue;
      find_earlier(i);
      if (earlier_.empty()) continue;
      const mass_moments<Real> shared = shared_by(i);
      real volume = 0;
      parts_.visit(i, [&](const auto& shape, const pose&, real) { volume = shape.volume(); });
      if (!(shared.mass > Real(1e-12) * volume)) continue;
      any = true;
      sum.mass -= density_[i] * shared.mass;
      sum.first -= density_[i] * shared.first;
      sum.second -= density_[i] * shared.second;
    }
    return any;
  }

 private:
  /// Solids around a part, which may have 2^10 intersections.
  static constexpr std::size_t most_clipped = 10;

  [[nodiscard]] part_ball<Real> ball_of(std::size_t i) const {
    return {parts_.entries[i].centre, parts_.entries[i].reach};
  }
  void find_earlier(std::size_t i) {
    earlier_.clear();
    const auto& e = parts_.entries[i];
    parts_.near(e.centre, e.reach, [&](std::size_t j) {
      if (order_[j] < order_[i] && density_[j] > 0 && may_meet(i, j)) earlier_.push_back(j);
    });
    std::sort(earlier_.begin(), earlier_.end(),
              [&](std::size_t a, std::size_t b) { return order_[a] < order_[b]; });
  }
  [[nodiscard]] bool may_meet(std::size_t i, std::size_t j) const {
    if (is_ball_[i] && is_ball_[j]) return balls_meet(ball_of(i), ball_of(j));
    bool meet = true;
    if constexpr (!only_spheres)
      parts_.visit(i, [&](const auto& a, const pose& of_a, real) {
        parts_.visit(j, [&](const auto& b, const pose& of_b, real) {
          meet = boxes_meet(a, of_a, b, of_b) && boxes_meet(b, of_b, a, of_a);
        });
      });
    return meet;
  }
  /// Whether the boxes around two shapes meet, in the frame of the first.
  template <class A, class B>
  [[nodiscard]] static bool boxes_meet(const A& a, const pose& of_a, const B& b, const pose& of_b) {
    const pose there = combined(inverse(of_a), of_b);
    const vec3 half = a.half_extents(pose{}) + b.half_extents({{0, 0, 0}, there.orientation});
    for (int k = 0; k < 3; ++k)
      if (!(std::abs(there.position[k]) < half[k] * (1 - 1e-12))) return false;
    return true;
  }
  [[nodiscard]] mass_moments<Real> shared_by(std::size_t i) {
    bool balls = is_ball_[i];
    for (const std::size_t j : earlier_) balls = balls && is_ball_[j];
    if (balls) {
      std::vector<part_ball<Real>> others;
      for (const std::size_t j : earlier_) others.push_back(ball_of(j));
      return shared_by_many<Real>(ball_of(i), others).moments();
    }
    bool flat = is_flat_[i] && earlier_.size() <= most_clipped;
    for (const std::size_t j : earlier_) flat = flat && is_flat_[j];
    mass_moments<Real> sum;
    if constexpr ((... || is_flat_solid<Shapes>))
      if (flat) {
        parts_.visit(i, [&]<class A>(const A& a, const pose& at, real) {
          if constexpr (is_flat_solid<A>) sum = turned(by_clipping(a, at), at);
        });
        return sum;
      }
    if constexpr (!only_spheres)
      parts_.visit(i,
                   [&](const auto& a, const pose& at, real) { sum = turned(by_lines(a, at), at); });
    return sum;
  }
  /// In the frame of the part.
  template <class A>
  [[nodiscard]] mass_moments<Real> by_clipping(const A& a, const pose& at) {
    std::vector<std::vector<face_plane>> others;
    const pose back = inverse(at);
    for (const std::size_t j : earlier_)
      parts_.visit(j, [&]<class B>(const B& b, const pose& of_b, real) {
        if constexpr (is_flat_solid<B>) others.push_back(face_planes_of(b, combined(back, of_b)));
      });
    mass_moments<Real> sum;
    add_shared_by_solids<Real>(solid_of(a), others, 0, Real(1), 1e-13 * a.bounding_radius(), sum);
    return sum;
  }
  /// In the frame of the part.
  template <class A>
  [[nodiscard]] mass_moments<Real> by_lines(const A& a, const pose& at) {
    std::vector<part_bounds> bounds;
    const pose back = inverse(at);
    std::vector<pose> places;      // of the others, in the frame of the part
    std::vector<pose> turns;       // from the frame of the part to those of the others
    std::vector<vec3> directions;  // of the lines, in the frames of the others
    bool exact = has_chord<A>;
    for (const std::size_t j : earlier_)
      parts_.visit(j, [&]<class B>(const B& b, const pose& of_b, real) {
        exact = exact && has_chord<B>;
        const pose there = combined(back, of_b);
        const vec3 reach = b.half_extents({{0, 0, 0}, there.orientation});
        bounds.push_back({there.position - reach, there.position + reach});
        places.push_back(there);
        turns.push_back(inverse({{0, 0, 0}, there.orientation}));
        directions.push_back(turns.back().to_world(vec3(1, 0, 0)));
      });
    return shared_by_parts(
        a.half_extents(pose{}), bounds, exact ? line_budget{} : searched,
        [&](std::size_t n, const vec3& p) {
          if (n == 0) return chord_of(a, p, vec3(1, 0, 0));
          chord found = no_chord;
          parts_.visit(earlier_[n - 1], [&](const auto& b, const pose&, real) {
            found = chord_of(b, places[n - 1].to_body(p), directions[n - 1]);
          });
          return found;
        },
        [&](std::size_t n, const vec3& d) {
          if (n == 0) return d.dot(a.support(d));
          real reach = 0;
          parts_.visit(earlier_[n - 1], [&](const auto& b, const pose&, real) {
            const vec3 turned = turns[n - 1].to_world(d);
            reach = d.dot(places[n - 1].position) + turned.dot(b.support(turned));
          });
          return reach;
        });
  }
  /// About the origin, from moments in a frame.
  [[nodiscard]] static mass_moments<Real> turned(const mass_moments<Real>& m, const pose& at) {
    const matrix3<Real> turn = at.orientation.toRotationMatrix();
    const vector3<Real> c = at.position, first = turn * m.first;
    return {m.mass, first + m.mass * c,
            turn * m.second * turn.transpose() + outer(c, first) + outer(first, c) +
                m.mass * outer(c, c)};
  }

  const parts_type& parts_;
  std::vector<real> density_;
  std::vector<std::uint32_t> order_;  ///< of each part, by density
  std::vector<bool> is_ball_, is_flat_;
  std::vector<std::size_t> earlier_;
};

}  // namespace talus::detail
