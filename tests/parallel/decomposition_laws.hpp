#pragma once
// The laws of every decomposition. A new one calls decomposition_laws() in its test, with a few of
// its forms.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "../vectors.hpp"
#include "talus/parallel/check_connections.hpp"
#include "talus/parallel/domain.hpp"

namespace talus::laws {

/// Points at which ownership is difficult: on and next to planes, edges and corners; signed zeros,
/// denormal and huge numbers; and points anywhere.
class hard_points {
 public:
  hard_points(std::vector<half_space> planes, std::uint64_t seed)
      : planes_(std::move(planes)), random_(seed) {
    for (const half_space& h : planes_) size_ = std::max(size_, 2 * std::abs(h.displacement()));
  }

  vec3 next() {
    vec3 p;
    for (int i = 0; i < 3; ++i) p[i] = coordinate();
    if (planes_.empty()) return p;
    std::vector<vec3> across;
    for (auto n = random_() % 4; n > 0; --n) {
      const half_space& h = planes_[random_() % planes_.size()];
      vec3 u = h.normal();
      for (const vec3& e : across) u -= h.normal().dot(e) * e;
      if (u.norm() < 1e-3) continue;
      u.normalize();
      int axis;
      if (std::abs(h.normal().cwiseAbs().maxCoeff(&axis)) == 1)
        p[axis] = h.displacement() * h.normal()[axis];  // on the plane exactly
      else if (const vec3 q = p - h.value(p) / h.normal().dot(u) * u; q.allFinite())
        p = q;
      across.push_back(u);
    }
    for (int i = 0; i < 3; ++i) p[i] = nudged(p[i]);
    return p;
  }
  real uniform() { return static_cast<real>(random_() >> 11) * 0x1p-53; }
  vec3 anywhere() { return 3 * size_ * vec3(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5); }
  real size() const { return size_; }

 private:
  real coordinate() {
    using limits = std::numeric_limits<real>;
    const real sign = random_() & 1 ? 1 : -1;
    switch (random_() % 16) {
      case 0:
        return sign * 0.0;
      case 1:
        return sign * limits::denorm_min() * real(1 + random_() % 4);
      case 2:
        return sign * limits::min();
      case 3:
        return sign * 1e300;
      case 4:
        return sign * limits::max();
      case 5:
        return sign * std::round(size_ * uniform());
      default:
        return sign * 2 * size_ * uniform();
    }
  }
  real nudged(real x) {
    constexpr real far = std::numeric_limits<real>::infinity();
    const int ulps = static_cast<int>(random_() % 16) - 8;
    if (ulps < -4 || ulps > 4) return x == 0 && random_() & 1 ? -x : x;
    for (int i = 0; i < std::abs(ulps); ++i) x = std::nextafter(x, ulps < 0 ? -far : far);
    return std::isfinite(x) ? x : 0;
  }

  std::vector<half_space> planes_;
  std::mt19937_64 random_;
  real size_ = 1;
};

/// Counts failures without the cost of an assertion per point, and prints the first.
class tally {
 public:
  explicit tally(std::string law) : law_(std::move(law)) {}
  ~tally() {
    INFO(law_, ": ", first_);
    CHECK(failures_ == 0);
  }
  tally(const tally&) = delete;
  template <class Describe>
  void expect(bool holds, Describe&& describe) {
    if (!holds && failures_++ == 0) first_ = describe();
  }

 private:
  std::string law_;
  std::size_t failures_ = 0;
  std::string first_;
};

inline std::string show(const vec3& p) {
  return fmt::format("({:a}, {:a}, {:a}) = {}", p[0], p[1], p[2], detail::text(p));
}

/// Runs all laws with `points` difficult points; returns how many points were tested. `tolerance`
/// is the (relative) deviation of the planes of geometry() from the rule of owner(): 0 for planes
/// without rounding.
template <concepts::generating_decomposition Decomposition>
std::size_t decomposition_laws(const Decomposition& d, int ranks, std::size_t points,
                               real tolerance = 0, std::uint64_t seed = 20240501) {
  constexpr real infinity = std::numeric_limits<real>::infinity();
  INFO("seed ", seed, ", ranks ", ranks);
  const auto cells = d.resolve(ranks);
  CHECK(cells.size() == ranks);
  CHECK((d.size() == 0 || d.size() == ranks));

  std::vector<domain<Decomposition>> domains;
  std::vector<any_geometry> regions;
  std::vector<std::vector<connection>> lists;
  std::vector<half_space> planes;
  std::vector<std::vector<int>> closed(ranks);  // ranks that touch, but are not connected
  for (int r = 0; r < ranks; ++r) {
    if constexpr (domain<Decomposition>::closing) closed[r] = cells.closed(r);
    domains.emplace_back(d, r, ranks);
    regions.push_back(cells.geometry(r));
    lists.emplace_back(domains[r].connections().begin(), domains[r].connections().end());
    for (const half_space& h : regions[r].planes()) planes.push_back(h);
  }
  hard_points source(planes, seed);
  const real size = source.size();
  const bool oblique = std::ranges::any_of(
      planes, [](const half_space& h) { return h.normal().cwiseAbs().maxCoeff() < 1; });

  {
    tally law("boundaries are bit-identical from both sides");
    for (int r = 0; r < ranks; ++r) {
      for (const half_space& h : regions[r].planes()) {
        const auto meets = [&](const any_geometry& g) {
          return std::ranges::count(g.planes(), h.flipped()) == 1;
        };
        const bool met =
            std::ranges::any_of(lists[r], [&](const auto& c) { return meets(c.geometry); }) ||
            std::ranges::any_of(closed[r], [&](int s) { return meets(regions[s]); });
        law.expect(met, [&] { return "no neighbour has the other side of " + to_string(h); });
      }
      for (const connection& c : lists[r])
        law.expect(c.geometry == regions[c.rank],
                   [&] { return fmt::format("rank {} sees rank {} differently", r, c.rank); });
    }
  }
  {  // Neighbourhood is symmetric, sorted, without repetition and without the rank itself.
    tally law("connections are symmetric");
    for (const real reach : {0.0, 0.1 * size, 0.7 * size, 10 * size})
      for (int r = 0; r < ranks; ++r) {
        const auto near = cells.neighbours(r, reach);
        law.expect(std::ranges::adjacent_find(near, std::greater_equal<>{}) == near.end(),
                   [&] { return fmt::format("neighbours of {} are not ascending", r); });
        for (const int s : near) {
          const auto back = cells.neighbours(s, reach);
          law.expect(s != r && std::ranges::find(back, r) != back.end(),
                     [&] { return fmt::format("{} is a neighbour of {}, not the reverse", s, r); });
        }
      }
  }
  {
    tally law("closed faces are closed from both sides, and nobody is connected across them");
    for (int r = 0; r < ranks; ++r) {
      law.expect(std::ranges::adjacent_find(closed[r], std::greater_equal<>{}) == closed[r].end(),
                 [&] { return fmt::format("closed({}) is not ascending", r); });
      for (const int s : closed[r]) {
        law.expect(std::ranges::binary_search(closed[s], r),
                   [&] { return fmt::format("{} is closed to {}, not the reverse", s, r); });
        law.expect(s != r && !domains[r].find(s),
                   [&] { return fmt::format("{} is closed and connected to {}", s, r); });
      }
    }
  }
  {
    tally tiles("every point has exactly one owner, and all ranks agree on it");
    tally inside("the region of a rank contains its own points");
    tally touching("ranks whose points are next to each other are neighbours, or closed");
    tally bounded("all points of a rank lie within its bounds");
    std::vector<std::pair<vec3, vec3>> bounds;
    for (const auto& domain : domains) bounds.push_back(domain.bounds());
    for (std::size_t i = 0; i < points; ++i) {
      const vec3 p = source.next();
      const int owner = cells.owner(p);
      tiles.expect(owner >= 0 && owner < ranks, [&] { return "no owner for " + show(p); });
      if (owner < 0 || owner >= ranks) continue;
      int claims = 0;
      for (const auto& domain : domains) claims += domain.contains(p);
      tiles.expect(claims == 1 && domains[owner].contains(p), [&] {
        return fmt::format("{} ranks contain {}, owner says {}", claims, show(p), owner);
      });
      const int other = static_cast<int>(i % ranks);
      const int seen = domains[other].owner(p);
      const bool knows = other == owner || domains[other].find(owner);
      tiles.expect(seen == (knows ? owner : -1), [&] {
        return fmt::format("{} belongs to {}, rank {} says {}", show(p), owner, other, seen);
      });
      const real slack = tolerance * (size + p.cwiseAbs().maxCoeff());
      inside.expect(regions[owner].value(p) >= -slack,
                    [&] { return fmt::format("{} lies outside of rank {}", show(p), owner); });
      if (tolerance == 0)
        inside.expect(regions[owner].owns(p) && (other == owner || !regions[other].owns(p)),
                      [&] { return fmt::format("{}: owner {}, not as owns()", show(p), owner); });
      const auto& [lower, upper] = bounds[owner];
      bounded.expect(
          at_most(lower - vec3::Constant(slack), p) && at_most(p, upper + vec3::Constant(slack)),
          [&] { return fmt::format("{} of rank {}", show(p), owner); });
      // The next corner of the box of a few ulps around p.
      vec3 q = p;
      for (int k = 0; k < 3; ++k)
        q[k] = std::nextafter(p[k], (i >> k & 1 ? 1 : -1) * std::numeric_limits<real>::max());
      const int beside = cells.owner(q);
      // So far away that neighbouring numbers are whole cells apart, the law does not apply.
      if (oblique && p.cwiseAbs().maxCoeff() > 1e9 * size) continue;
      touching.expect(beside == owner || domains[owner].find(beside) ||
                          std::ranges::binary_search(closed[owner], beside),
                      [&] {
                        return fmt::format("{}: rank {} is not connected to {} beside it", show(p),
                                           owner, beside);
                      });
    }
    for (int i = 0; i < 27; ++i) {
      const auto far = [&](int digit) { return std::array{-infinity, 0.1, infinity}[digit % 3]; };
      const vec3 p(far(i), far(i / 3), far(i / 9));
      const int owner = cells.owner(p);
      tiles.expect(owner >= 0 && owner < ranks, [&] { return "no owner for " + show(p); });
    }
    CHECK(cells.owner({std::nan(""), 0, 0}) == -1);
    CHECK(!domains[0].contains({0, std::nan(""), 0}));
  }
  {
    tally bound("-value(p) is at most the distance of p from the region");
    tally interior("interior_distance(p) is at most the distance of p from all other ranks");
    tally complete("every point within reach belongs to a neighbour, or lies behind a closed face");
    tally away("the distance from a closed face is at most that of any point behind it");
    std::vector<std::vector<int>> near;
    std::vector<real> reaches{0.05 * size, 0.3 * size, 1.5 * size};
    for (const real reach : reaches)
      for (int r = 0; r < ranks; ++r) near.push_back(cells.neighbours(r, reach));
    for (std::size_t i = 0; i < std::max<std::size_t>(points / 8, 10000); ++i) {
      const auto which = i % reaches.size();
      const vec3 p = source.anywhere();
      vec3 step = vec3(source.uniform() - 0.5, source.uniform() - 0.5, source.uniform() - 0.5);
      step *= reaches[which] * source.uniform() / (step.norm() + 1e-300);
      const vec3 q = p + step;
      const int a = cells.owner(p), b = cells.owner(q);
      const real distance = (p - q).norm(), slack = 1e-14 * size;
      bound.expect(-regions[b].value(p) <= distance + slack,
                   [&] { return fmt::format("{} to {} of rank {}", show(p), show(q), b); });
      if (a == b) continue;
      interior.expect(domains[a].interior_distance(p) <= distance + slack,
                      [&] { return fmt::format("{} to {}", show(p), show(q)); });
      if (const connection* c = domains[a].find(b))
        bound.expect(c->distance(p) <= distance + slack, [&] { return show(p); });
      complete.expect(std::ranges::binary_search(near[which * ranks + a], b) ||
                          std::ranges::binary_search(closed[a], b),
                      [&] {
                        return fmt::format("rank {} is {} from {}, which does not know", b,
                                           distance, a);
                      });
      if constexpr (domain<Decomposition>::closing)
        for (const closed_neighbour& c : domains[a].closed()) {
          if (c.rank() != b) continue;
          const auto place = c.within(p, distance + slack);
          away.expect(place && place->distance <= distance + slack &&
                          place->distance >= -regions[b].value(p) - slack,
                      [&] { return fmt::format("{} to {} of rank {}", show(p), show(q), b); });
        }
    }
  }
  const auto flaws = check_connections(lists, cells, {.samples = 50});
  INFO((flaws.empty() ? std::string() : flaws[0].message));
  CHECK(flaws.empty());
  return points;
}

}  // namespace talus::laws
