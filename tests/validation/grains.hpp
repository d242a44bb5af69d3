#pragma once
// Common parts of the tests of granular media: spheres in a box on any number of ranks, their state
// in one place, bulk packing fraction and coordination.
#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <talus/observe/motion.hpp>
#include <talus/parallel/serial.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/scene/lattice.hpp>
#include <talus/world/world.hpp>
#include <vector>
#include "../vectors.hpp"

namespace talus::validation {

/// A sphere at one instant.
struct grain {
  vec3 position, velocity;
  real radius = 0;
};

/// Grains of all ranks, in one order for any number of ranks; filled by gather().
class snapshot {
 public:
  /// All ranks call it; complete when launch() has returned or after the barrier in the link.
  template <class Scenario>
  void gather(world<Scenario>& w) {
    {
      const std::lock_guard lock(mutex_);
      w.for_each_local([&](const auto& b) {
        if constexpr (std::is_same_v<typename std::remove_cvref_t<decltype(b)>::shape_type, sphere>)
          if (!b.is_fixed()) grains_.push_back({b.position(), b.velocity(), b.shape().radius});
      });
    }
    w.link().barrier();
  }
  [[nodiscard]] const std::vector<grain>& all() const { return grains_; }

 private:
  std::mutex mutex_;
  std::vector<grain> grains_;
};

/// Grains by cells wider than any of them.
class cell_index {
 public:
  explicit cell_index(const std::vector<grain>& grains) : grains_(grains) {
    for (const grain& g : grains) width_ = std::max(width_, 2.02 * g.radius);
    for (std::size_t i = 0; i < grains.size(); ++i) cells_[key(grains[i].position)].push_back(i);
  }
  /// Calls f(i) for all grains that may come within their radius and that of the largest one.
  template <class F>
  void near(const vec3& p, F&& f) const {
    const vec3 d(width_, width_, width_);
    const auto low = key(p - d), high = key(p + d);
    for (long x = low[0]; x <= high[0]; ++x)
      for (long y = low[1]; y <= high[1]; ++y)
        for (long z = low[2]; z <= high[2]; ++z)
          if (const auto at = cells_.find({x, y, z}); at != cells_.end())
            for (const std::size_t i : at->second) f(i);
  }

 private:
  using cell = std::array<long, 3>;
  [[nodiscard]] cell key(const vec3& p) const {
    return {std::lround(p[0] / width_), std::lround(p[1] / width_), std::lround(p[2] / width_)};
  }
  const std::vector<grain>& grains_;
  real width_ = 0;
  std::map<cell, std::vector<std::size_t>> cells_;
};

/// Part of the box between two corners that is inside grains: a grid of points 1/8 of the mean
/// radius apart or coarser, at most a million.
inline real packing_fraction(const std::vector<grain>& grains, const vec3& lower,
                             const vec3& upper) {
  const cell_index cells(grains);
  const real step = std::cbrt(product_of(upper - lower) / 4e5);
  std::size_t inside = 0, points = 0;
  for (real x = lower[0] + step / 2; x < upper[0]; x += step)
    for (real y = lower[1] + step / 2; y < upper[1]; y += step)
      for (real z = lower[2] + step / 2; z < upper[2]; z += step) {
        const vec3 p(x, y, z);
        bool hit = false;
        cells.near(p, [&](std::size_t i) {
          hit = hit || (grains[i].position - p).squaredNorm() < grains[i].radius * grains[i].radius;
        });
        ++points;
        inside += hit;
      }
  return static_cast<real>(inside) / static_cast<real>(points);
}

/// Mean number of contacts of a grain with its centre between two corners: gaps up to `touch` of
/// the mean radius count. `rattlers`: the part with fewer than two.
struct coordination {
  real mean = 0, without_rattlers = 0, rattlers = 0;
};
inline coordination coordination_number(const std::vector<grain>& grains, const vec3& lower,
                                        const vec3& upper, real touch = 1e-3) {
  const cell_index cells(grains);
  coordination z;
  std::size_t n = 0, idle = 0;
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const grain& g = grains[i];
    if (!at_most(lower, g.position) || !at_most(g.position, upper)) continue;
    std::size_t own = 0;
    cells.near(g.position, [&](std::size_t j) {
      const real gap = (grains[j].position - g.position).norm() - g.radius - grains[j].radius;
      own += j != i && gap < touch * g.radius;
    });
    ++n, idle += own < 2;
    z.mean += static_cast<real>(own);
    if (own >= 2) z.without_rattlers += static_cast<real>(own);
  }
  z.mean /= static_cast<real>(n);
  z.without_rattlers /= static_cast<real>(n - idle);
  z.rattlers = static_cast<real>(idle) / static_cast<real>(n);
  return z;
}

/// Least squares line through points: {value at 0, slope}.
inline std::array<real, 2> line_through(const std::vector<std::array<real, 2>>& points) {
  real n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [a, b] : points) n += 1, x += a, y += b, xx += a * a, xy += a * b;
  const real slope = (n * xy - x * y) / (n * xx - x * x);
  return {(y - slope * x) / n, slope};
}

}  // namespace talus::validation
