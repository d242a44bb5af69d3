#pragma once
// Posed shapes of any kind for tests of contacts, with independent references: a support function,
// and how far a point is outside.
#include <functional>
#include <random>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "../generator.hpp"
#include "talus/detect/narrow.hpp"

namespace solids {

using namespace talus;
using contacts = std::vector<contact_geometry>;

/// Signed distance from the surface, in the frame of the body: exact on the surface, and of the
/// correct sign.
inline real outside(const sphere& s, const vec3& p) { return p.norm() - s.radius; }
inline real outside(const box& s, const vec3& p) { return (p.cwiseAbs() - s.half()).maxCoeff(); }
inline real outside(const capsule& s, const vec3& p) {
  const real z = std::max(real(0), std::abs(p[2]) - s.length / 2);
  return std::hypot(p[0], p[1], z) - s.radius;
}
inline real outside(const cylinder& s, const vec3& p) {
  return std::max(std::hypot(p[0], p[1]) - s.radius, std::abs(p[2]) - s.length / 2);
}
inline real outside(const convex_polyhedron& s, const vec3& p) {
  real most = -1e300;
  for (std::size_t f = 0; f < s.mesh().faces(); ++f)
    most = std::max(most, s.mesh().normals[f].dot(p) - s.mesh().offsets[f]);
  return most;
}

using any_shape = std::variant<sphere, box, capsule, cylinder, convex_polyhedron>;

struct solid {
  any_shape shape;
  pose at;

  [[nodiscard]] std::string name() const {
    return std::visit([](const auto& s) { return std::string(s.name); }, shape);
  }
  [[nodiscard]] real radius() const {
    return std::visit([](const auto& s) { return s.bounding_radius(); }, shape);
  }
  /// The scale of tolerances.
  [[nodiscard]] real smallest() const {
    struct {
      real operator()(const sphere& s) { return s.radius; }
      real operator()(const box& s) { return s.half().minCoeff(); }
      real operator()(const capsule& s) { return s.radius; }
      real operator()(const cylinder& s) { return std::min(s.radius, s.length / 2); }
      real operator()(const convex_polyhedron& s) { return s.mesh().measured.half_width; }
    } measure;
    return std::visit(measure, shape);
  }
  [[nodiscard]] vec3 support(const vec3& d) const {
    const vec3 local = at.orientation.conjugate() * d;
    return at.to_world(std::visit([&](const auto& s) { return vec3(s.support(local)); }, shape));
  }
  [[nodiscard]] real outside(const vec3& p) const {
    const vec3 local = at.to_body(p);
    return std::visit([&](const auto& s) { return solids::outside(s, local); }, shape);
  }
  [[nodiscard]] solid moved(const pose& by) const {
    return {shape, {by.to_world(at.position), by.orientation * at.orientation}};
  }
};

inline contacts find(const solid& a, const solid& b, real margin) {
  contacts found;
  std::visit(
      [&](const auto& s, const auto& t) {
        collide_pair(s, a.at, t, b.at, margin,
                     [&](const contact_geometry& c) { found.push_back(c); });
      },
      a.shape, b.shape);
  return found;
}

inline real smallest_gap(const contacts& all) {
  real gap = 1e300;
  for (const contact_geometry& c : all) gap = std::min(gap, c.gap);
  return gap;
}
inline const contact_geometry& deepest(const contacts& all) {
  return *std::min_element(all.begin(), all.end(),
                           [](const auto& x, const auto& y) { return x.gap < y.gap; });
}
inline std::set<std::uint64_t> feature_ids(const contacts& all) {
  std::set<std::uint64_t> names;
  for (const contact_geometry& c : all) names.insert(c.feature);
  return names;
}

/// Gap along a unit direction from b to a, by support functions. The largest over all directions is
/// the distance, or minus the depth of the overlap.
inline real gap_along(const solid& a, const solid& b, const vec3& n) {
  return n.dot(a.support(-n)) - n.dot(b.support(n));
}

/// The largest gap of many directions, each improved by small steps; `start` is one of them.
inline real best_gap(const solid& a, const solid& b, const vec3& start, generator& random,
                     int samples) {
  const auto climb = [&](vec3 n, real now, real step, real end) {
    while (step > end) {
      bool better = false;
      const vec3 u = n.cross(vec3::Unit(std::abs(n[0]) < 0.6 ? 0 : 1)).normalized(), v = n.cross(u);
      for (int k = 0; k < 8; ++k) {
        const real turn = k * pi / 4 + random(0, 1);
        const vec3 next = (n + step * (std::cos(turn) * u + std::sin(turn) * v)).normalized();
        const real gap = gap_along(a, b, next);
        if (gap > now) now = gap, n = next, better = true;
      }
      if (!better) step *= 0.6;
    }
    return now;
  };
  real best = climb(start, gap_along(a, b, start), 0.1, 1e-9);
  for (int k = 0; k < 8; ++k) {
    const vec3 near = (start + 0.1 * random.point(1)).normalized();
    best = std::max(best, climb(near, gap_along(a, b, near), 0.05, 1e-9));
  }
  for (int k = 0; k < samples; ++k) {
    const vec3 n = random.direction();
    const real gap = gap_along(a, b, n);
    if (gap > best - 0.5 * std::min(a.smallest(), b.smallest()))
      best = std::max(best, climb(n, gap, 0.1, 1e-3));
  }
  return best;
}

inline any_shape random_shape(std::size_t kind, generator& random) {
  const real flat = random(0, 1) < 0.2 ? 0.05 : 0.3;
  switch (kind) {
    case 0:
      return sphere{random(flat, 1)};
    case 1:
      return box{{random(flat, 2), random(flat, 2), random(flat, 2)}};
    case 2:
      return capsule{random(flat, 0.7), random(flat, 2)};
    case 3:
      return cylinder{random(flat, 1), random(flat, 2)};
    default:
      break;
  }
  const auto kinds = random(0, 4);
  std::vector<vec3> points;
  if (kinds < 1) {  // a prism
    const int corners = 3 + static_cast<int>(random(0, 6));
    const real height = random(flat, 1);
    for (int k = 0; k < corners; ++k)
      for (const real z : {0., height})
        points.push_back({std::cos(2 * pi * k / corners), std::sin(2 * pi * k / corners), z});
  } else if (kinds < 2) {  // a block
    const vec3 size{random(flat, 2), random(flat, 2), random(flat, 2)};
    for (unsigned c = 0; c < 8; ++c)
      points.push_back(size.cwiseProduct(vec3(c & 1u, c >> 1 & 1u, c >> 2)));
  } else {  // a grain
    const int corners = 4 + static_cast<int>(random(0, 20));
    const vec3 size{random(0.4, 1), random(0.4, 1), random(0.4, 1)};
    for (int k = 0; k < corners; ++k) points.push_back(size.cwiseProduct(random.direction()));
    try {
      const convex_polyhedron p(points);
      if (p.mesh().measured.half_width > 0.05) return p;
    } catch (const std::invalid_argument&) {
    }
    return random_shape(kind, random);
  }
  return convex_polyhedron(points);
}

}  // namespace solids
