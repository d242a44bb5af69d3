#pragma once
// Computes the cuts of recursive bisection for a load distributed over ranks, level by level, by
// histograms that become finer around each cut. Each rank holds only its own part of the load. Each
// level takes some reductions of 64 numbers for each part.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "talus/core/plain_vector.hpp"
#include "talus/parallel/bisection_cells.hpp"
#include "talus/parallel/reduction.hpp"

namespace talus::detail {

/// The box that is divided: axes that are not open are never cut.
struct cut_bounds {
  std::array<real, 3> lower{}, upper{};
  std::array<bool, 3> open{};
};

/// No domain becomes narrower than this fraction of the bounds.
inline constexpr real narrowest = 1e-6;

/// A part of space with several ranks.
struct part_to_cut {
  std::size_t number = 0;  ///< of its cut
  int ranks = 1;
  part_of_space space{};
  bisection_cut cut{};

  [[nodiscard]] int below() const { return ranks_below(ranks); }
  [[nodiscard]] std::array<part_to_cut, 2> halves() const;
  /// The extent whose volume is divided: within the bounds, or as wide as they are if the part lies
  /// beyond them.
  [[nodiscard]] std::array<real, 2> range(const cut_bounds& box, std::size_t axis) const;
  void cut_volume(const cut_bounds& box, int axis);
  /// Midway between two points, with enough width for all ranks on each side. If one of the sides
  /// is empty, the points are infinite and the volume is cut.
  void cut_between(real last, real next, const cut_bounds& box);
};

/// The open axis with the largest extent; the lowest of equal ones.
[[nodiscard]] int longest_axis(const std::array<real, 3>& extents, const cut_bounds& box);
[[nodiscard]] int longest_axis(const part_to_cut& part, const cut_bounds& box);

/// All parts, by number, cut so that each rank has the same volume of the box.
[[nodiscard, gnu::cold]] std::vector<part_to_cut> equal_parts(const cut_bounds& box, int ranks);

/// The interval in which a cut lies, and the weight below it.
struct cut_search {
  static constexpr std::size_t bins = 64;

  real from = 0, to = 0;
  std::uint64_t below = 0, total = 0, target = 0, enough = 0;
  bool found = false;

  [[nodiscard]] real edge(std::size_t k) const;
  /// Whose edges the position is between, exactly; `bins` where it is outside.
  [[nodiscard]] std::size_t bin(real x) const;
  /// Continues in the bin that holds the target. In the last round, or if finer bins have no
  /// effect, it ends there, with the nearer edge as `from`.
  void narrow(std::span<const std::uint64_t> weights, bool last);
};

/// Cuts a load of which each rank of a link holds some points, with one weight per rank.
template <class Link>
class load_bisection {
 public:
  load_bisection(Link& link, std::span<const vec3> places, std::uint64_t weight)
      : link_(link), places_(places), weight_(weight) {}

  /// The cuts for the given number of ranks; `before` gives the previous axes. Collective.
  [[nodiscard, gnu::cold]] std::vector<bisection_cut> cuts(const cut_bounds& box,
                                                           const std::vector<bisection_cut>& before,
                                                           int ranks) {
    std::vector<bisection_cut> cuts(static_cast<std::size_t>(ranks - 1));
    plain_vector<part_to_cut> parts;
    if (ranks > 1) parts.push_back({.ranks = ranks});
    part_of_.assign(places_.size(), ranks > 1 ? 0 : settled);
    while (!parts.empty()) {
      measure_extents(parts.size());
      plain_vector<cut_search> searches(parts.size());
      for (std::size_t p = 0; p < parts.size(); ++p)
        begin(parts[p], searches[p], box, before.size() == cuts.size() ? &before : nullptr, p);
      for (int round = 0; round < most_rounds && !all_found(searches); ++round)
        refine(parts, searches, round == 0, round + 1 == most_rounds);
      move_between_neighbours(parts, searches, box);
      for (const part_to_cut& p : parts) cuts[p.number] = p.cut;
      divide(parts);
    }
    return cuts;
  }

 private:
  static constexpr std::uint32_t settled = ~std::uint32_t{0};
  static constexpr int most_rounds = 8;        // 64^8 bins are as fine as numbers are
  static constexpr real longer_by_half = 1.5;  // or the axis stays

  [[nodiscard]] static bool all_found(const plain_vector<cut_search>& searches) {
    return std::all_of(searches.begin(), searches.end(), [](const auto& s) { return s.found; });
  }
  template <class F>
  void each_place(F&& f) const {
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (part_of_[i] != settled) f(places_[i], part_of_[i]);
  }

  /// -lower and upper corner of the points in each part.
  void measure_extents(std::size_t parts) {
    extents_.assign(6 * parts, -part_of_space::infinity);
    each_place([&](const vec3& x, std::size_t p) {
      for (int k = 0; k < 3; ++k) {
        double* e = extents_.data() + 6 * p + k;
        e[0] = std::max(e[0], -x[k]), e[3] = std::max(e[3], x[k]);
      }
    });
    link_.reduce(reduction::max, std::span<double>(extents_.data(), extents_.size()));
  }
  void begin(part_to_cut& part, cut_search& search, const cut_bounds& box,
             const std::vector<bisection_cut>* before, std::size_t p) {
    std::array<real, 3> lengths{};
    for (std::size_t k = 0; k < 3; ++k) lengths[k] = extents_[6 * p + k] + extents_[6 * p + 3 + k];
    const bool empty = !(lengths[0] >= 0);
    int axis = empty ? longest_axis(part, box) : longest_axis(lengths, box);
    if (before != nullptr) {
      const int last = (*before)[part.number].axis;
      const auto a = static_cast<std::size_t>(axis), l = static_cast<std::size_t>(last);
      if (box.open[l] && (empty || !(lengths[a] > longer_by_half * lengths[l]))) axis = last;
    }
    part.cut.axis = axis;
    const auto k = static_cast<std::size_t>(axis);
    search.from = -extents_[6 * p + k];
    search.to = std::nextafter(extents_[6 * p + 3 + k], part_of_space::infinity);
    search.found = empty;
  }
  void refine(const plain_vector<part_to_cut>& parts, plain_vector<cut_search>& searches,
              bool first, bool last) {
    constexpr std::size_t bins = cut_search::bins;
    weights_.assign(bins * parts.size(), 0);
    each_place([&](const vec3& x, std::size_t p) {
      if (searches[p].found) return;
      const std::size_t k = searches[p].bin(x[parts[p].cut.axis]);
      if (k < bins) weights_[bins * p + k] += weight_;
    });
    link_.reduce(reduction::sum, std::span<std::uint64_t>(weights_.data(), weights_.size()));
    for (std::size_t p = 0; p < parts.size(); ++p) {
      cut_search& s = searches[p];
      if (s.found) continue;
      const std::span<const std::uint64_t> mine(weights_.data() + bins * p, bins);
      if (first) {
        for (const std::uint64_t w : mine) s.total += w;
        const auto ranks = static_cast<std::uint64_t>(parts[p].ranks);
        const auto below = static_cast<std::uint64_t>(parts[p].below());
        s.target = s.total / ranks * below + s.total % ranks * below / ranks;
        s.enough = s.total / ranks / 512;
      }
      s.narrow(mine, last);
    }
  }
  /// A cut lies midway between the points next to it, so that it does not cut through a layer of
  /// bodies. If one of its sides is empty, the volume is cut.
  void move_between_neighbours(plain_vector<part_to_cut>& parts,
                               const plain_vector<cut_search>& searches, const cut_bounds& box) {
    plain_vector<double> next(2 * parts.size(), -part_of_space::infinity);
    each_place([&](const vec3& x, std::size_t p) {
      const real at = x[parts[p].cut.axis];
      double& nearest = next[2 * p + (at < searches[p].from ? 0 : 1)];
      nearest = std::max(nearest, at < searches[p].from ? at : -at);
    });
    link_.reduce(reduction::max, std::span<double>(next.data(), next.size()));
    for (std::size_t p = 0; p < parts.size(); ++p)
      parts[p].cut_between(next[2 * p], -next[2 * p + 1], box);
  }
  /// The halves to be cut further, and the half of each point.
  void divide(plain_vector<part_to_cut>& parts) {
    plain_vector<part_to_cut> next;
    plain_vector<std::uint32_t> number(2 * parts.size(), settled);
    for (std::size_t p = 0; p < parts.size(); ++p)
      for (std::size_t side = 0; const part_to_cut& half : parts[p].halves()) {
        if (half.ranks > 1) {
          number[2 * p + side] = static_cast<std::uint32_t>(next.size());
          next.push_back(half);
        }
        ++side;
      }
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (part_of_[i] == settled) continue;
      const bisection_cut& c = parts[part_of_[i]].cut;
      part_of_[i] = number[2 * part_of_[i] + (places_[i][c.axis] < c.at ? 0 : 1)];
    }
    parts.swap(next);
  }

  Link& link_;
  std::span<const vec3> places_;
  std::uint64_t weight_;
  plain_vector<std::uint32_t> part_of_;  ///< which of the parts each point is in
  plain_vector<double> extents_;
  plain_vector<std::uint64_t> weights_;
};

}  // namespace talus::detail

#ifndef TALUS_COMPILED
#include "talus/parallel/detail/bisect_load_definitions.hpp"
#endif
