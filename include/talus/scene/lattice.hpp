#pragma once
// Infinite lattices, and the part of a lattice in a region. Sites are ordered by layers from the
// bottom, by rows of rising y in a layer, and by rising x in a row.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "talus/scene/region.hpp"

namespace talus {

/// Sites at origin + spacing (i, j, k).
struct simple_cubic {
  real spacing = 1;      ///< distance of neighbours (length)
  vec3 origin{0, 0, 0};  ///< one of the sites

  static constexpr std::int64_t period = 1;
  [[nodiscard]] vec3 step() const { return detail::thrice<real>(spacing); }
  [[nodiscard]] vec3 shift(bool, bool) const { return {0, 0, 0}; }
};

/// The corners and centres of cubes.
struct body_centred_cubic {
  real spacing = 1;      ///< edge of the cube; neighbours are sqrt(3)/2 of it apart
  vec3 origin{0, 0, 0};  ///< one of the sites

  static constexpr std::int64_t period = 2;
  [[nodiscard]] vec3 step() const { return {spacing, spacing, spacing / 2}; }
  [[nodiscard]] vec3 shift(bool, bool odd_layer) const;
};

/// The corners and the centres of faces of cubes.
struct face_centred_cubic {
  real spacing = 1;      ///< edge of the cube; neighbours are sqrt(1/2) of it apart
  vec3 origin{0, 0, 0};  ///< one of the sites

  static constexpr std::int64_t period = 2;
  [[nodiscard]] vec3 step() const { return {spacing, spacing / 2, spacing / 2}; }
  [[nodiscard]] vec3 shift(bool odd_row, bool odd_layer) const {
    return {odd_row != odd_layer ? spacing / 2 : 0, 0, 0};
  }
};

/// Close-packed layers of equal spheres, every other one above the gaps of the one below.
struct hexagonal_close_packed {
  real spacing = 1;      ///< distance of neighbours (length)
  vec3 origin{0, 0, 0};  ///< one of the sites

  static constexpr std::int64_t period = 2;
  [[nodiscard]] vec3 step() const;
  [[nodiscard]] vec3 shift(bool odd_row, bool odd_layer) const;
};

namespace detail {

/// Layers `period` apart are alike; site (i, j, k) is at origin + shift(row, layer) + step (i, j,
/// k) with a shift below a step.
template <class Lattice>
concept lattice = requires(const Lattice l) {
  { Lattice::period } -> std::convertible_to<std::int64_t>;
  { l.step() } -> std::convertible_to<vec3>;
  { l.shift(true, true) } -> std::convertible_to<vec3>;
};

}  // namespace detail

/// The sites of a lattice that lie in a region; made by `lattice & region`. Throws invalid_argument
/// if the region has no bounds (first(n) needs none above).
template <class Lattice, class Region>
class lattice_sites {
 public:
  using site_type = site;

  lattice_sites(Lattice lattice, Region region)
      : lattice_(std::move(lattice)), region_(std::move(region)), step_(lattice_.step()) {
    detail::require_positive(lattice_.spacing, "the spacing of a lattice");
    if (!detail::finite(lattice_.origin))
      detail::fail<std::invalid_argument>(
          "the origin of a lattice must be finite, but is {}; give the place of one site",
          detail::text(lattice_.origin));
  }

  /// The first n of the sites, from the lowest layer upwards, or from the layer of the lattice's
  /// origin if the region has no lowest point. In a region that is the same at every height
  /// (cylinder, box) each rank enumerates one layer once, and then its own part only; in other
  /// regions all sites up to the last one.
  [[nodiscard]] lattice_sites first(std::uint64_t n) const {
    lattice_sites sites = *this;
    sites.limit_ = limit_ ? std::min(*limit_, n) : n;
    return sites;
  }
  /// The result of `sites & other`.
  template <detail::site_filter Other>
  [[nodiscard]] auto within(Other other) const {
    if (limit_)
      detail::fail<std::invalid_argument>(
          "first(n) comes last: write (lattice & region & other).first(n)");
    return lattice_sites<Lattice, detail::both_regions<Region, Other>>(lattice_,
                                                                       {region_, std::move(other)});
  }

  template <class F>
  void for_each_in(const vec3& lower, const vec3& upper, F&& f) const {
    const detail::region_extent extent = detail::extent_of(region_);
    const ranges all = bounded_ranges(extent);
    const ranges part = all.within(index_ranges(lower, upper));
    const auto emit = [&](std::int64_t i, std::int64_t j, std::int64_t k, const vec3& p) {
      if (!detail::between(lower, p, upper)) return;
      const std::uint64_t index = all.index(i, j, k);
      if (index >= static_cast<std::uint64_t>(most_)) fail_too_many(static_cast<real>(index));
      f(site{p, {1, 0, 0, 0}, index});
    };
    if (!limit_)
      part.for_each([&](auto i, auto j, auto k) {
        if (const vec3 p = position(i, j, k); region_.contains(p)) emit(i, j, k, p);
      });
    else if (extent.prism)
      first_in_prism(extent, all, part, emit);
    else
      first_anywhere(all, emit);
  }

 private:
  /// Inclusive ranges of the three indices, and the numbering of what is in them.
  struct ranges {
    std::array<std::int64_t, 3> first, last;

    [[nodiscard]] std::int64_t size(int axis) const {
      return std::max<std::int64_t>(last[axis] - first[axis] + 1, 0);
    }
    [[nodiscard]] ranges within(const ranges& other) const {
      ranges r;
      for (int a = 0; a < 3; ++a) {
        r.first[a] = std::max(first[a], other.first[a]);
        r.last[a] = std::min(last[a], other.last[a]);
      }
      return r;
    }
    [[nodiscard]] std::uint64_t index(std::int64_t i, std::int64_t j, std::int64_t k) const {
      return static_cast<std::uint64_t>(i - first[0] +
                                        size(0) * (j - first[1] + size(1) * (k - first[2])));
    }
    template <class F>
    void for_each_in_layer(F&& f) const {
      for (std::int64_t j = first[1]; j <= last[1]; ++j)
        for (std::int64_t i = first[0]; i <= last[0]; ++i) f(i, j);
    }
    template <class F>
    void for_each(F&& f) const {
      for (std::int64_t k = first[2]; k <= last[2]; ++k)
        for_each_in_layer([&](auto i, auto j) { f(i, j, k); });
    }
  };

  static constexpr std::int64_t most_ = std::int64_t{1} << 48;

  [[nodiscard]] vec3 position(std::int64_t i, std::int64_t j, std::int64_t k) const {
    const vec3 base = lattice_.origin + lattice_.shift(j & 1, k & 1);
    // The explicit fma makes the sites the same to the bit in every build.
    return {std::fma(static_cast<real>(i), step_[0], base[0]),
            std::fma(static_cast<real>(j), step_[1], base[1]),
            std::fma(static_cast<real>(k), step_[2], base[2])};
  }

  /// Indices of all sites between two corners, and of some more.
  [[nodiscard]] ranges index_ranges(const vec3& lower, const vec3& upper) const {
    constexpr real most = static_cast<real>(most_);
    ranges r;
    for (int a = 0; a < 3; ++a) {
      const auto at = [&](real x) {
        return std::clamp((x - lattice_.origin[a]) / step_[a], -most, most);
      };
      r.first[a] = static_cast<std::int64_t>(std::floor(at(lower[a]))) - 2;
      r.last[a] = static_cast<std::int64_t>(std::ceil(at(upper[a]))) + 2;
    }
    return r;
  }

  [[nodiscard]] ranges bounded_ranges(const detail::region_extent& extent) const {
    ranges r = index_ranges(extent.lower, extent.upper);
    for (int a = 0; a < 3; ++a) {
      const bool low = std::isfinite(extent.lower[a]) || (a == 2 && limit_);
      const bool high = std::isfinite(extent.upper[a]) || (a == 2 && limit_ && extent.prism);
      if (!low || !high)
        detail::fail<std::invalid_argument>(
            "the region to fill has no end in the direction {}{}: intersect it with a "
            "box_region{}",
            low ? '+' : '-', "xyz"[a],
            a == 2 && !limit_ ? ", or end the sites with .first(n)" : "");
    }
    if (limit_ && !std::isfinite(extent.lower[2])) r.first[2] = 0;
    const real sites = static_cast<real>(r.size(0)) * static_cast<real>(r.size(1)) *
                       static_cast<real>(std::isfinite(extent.upper[2]) ? r.size(2) : 1);
    if (sites > static_cast<real>(most_)) fail_too_many(sites);
    return r;
  }
  [[noreturn]] static void fail_too_many(real sites) {
    detail::fail<std::invalid_argument>(
        "the region to fill spans {} sites of the lattice, more than the 2^48 that ids can "
        "tell apart: use a smaller region or a larger spacing",
        detail::text(sites, 3));
  }

  /// Layers of a prism have equal numbers of sites (or two numbers in turn), so that the place of a
  /// site in the order follows from one table a layer.
  template <class Emit>
  void first_in_prism(const detail::region_extent& extent, const ranges& all, const ranges& part,
                      Emit&& emit) const {
    const auto height = [&](std::int64_t k) { return position(0, 0, k)[2]; };
    std::int64_t bottom = all.first[2], top = all.last[2];
    while (bottom <= top && height(bottom) < extent.lower[2]) ++bottom;
    while (top >= bottom && height(top) > extent.upper[2]) --top;

    constexpr std::uint32_t outside = ~std::uint32_t{0};
    constexpr std::int64_t period = Lattice::period;
    std::array<std::vector<std::uint32_t>, period> place;  // in the layer, by layer modulo period
    std::array<std::uint64_t, period> count{};
    for (std::int64_t n = 0; n < period && bottom + n <= top; ++n)
      all.for_each_in_layer([&](auto i, auto j) {
        const bool in = region_.contains(position(i, j, bottom + n));
        place[n].push_back(in ? static_cast<std::uint32_t>(count[n]++) : outside);
      });

    const std::uint64_t whole = count[0] + (period > 1 ? count[period - 1] : 0);
    const auto sites_below = [&](std::int64_t k) {
      const auto layers = static_cast<std::uint64_t>(k - bottom);
      return layers / period * whole + (layers % period ? count[0] : 0);
    };
    const bool ends = std::isfinite(extent.upper[2]) || whole == 0;
    if (const auto there = ends ? sites_below(top + 1) : *limit_; there < *limit_)
      detail::fail_too_few_sites(*limit_, there);

    for (std::int64_t k = std::max(bottom, part.first[2]); k <= std::min(top, part.last[2]); ++k) {
      const std::uint64_t below = sites_below(k);
      if (below >= *limit_) break;
      const auto& places = place[static_cast<std::size_t>((k - bottom) % period)];
      part.for_each_in_layer([&](auto i, auto j) {
        const auto at = places[all.index(i, j, all.first[2])];
        if (at != outside && below + at < *limit_) emit(i, j, k, position(i, j, k));
      });
    }
  }

  template <class Emit>
  void first_anywhere(const ranges& all, Emit&& emit) const {
    std::uint64_t seen = 0;
    for (std::int64_t k = all.first[2]; k <= all.last[2] && seen < *limit_; ++k)
      all.for_each_in_layer([&](auto i, auto j) {
        if (const vec3 p = position(i, j, k); region_.contains(p) && seen++ < *limit_)
          emit(i, j, k, p);
      });
    if (seen < *limit_) detail::fail_too_few_sites(*limit_, seen);
  }

  Lattice lattice_;
  Region region_;
  vec3 step_;
  std::optional<std::uint64_t> limit_;
};

template <detail::lattice Lattice, detail::site_filter Region>
[[nodiscard]] auto operator&(Lattice lattice, Region region) {
  return lattice_sites<Lattice, Region>(std::move(lattice), std::move(region));
}

}  // namespace talus

#ifndef TALUS_COMPILED
#include "talus/scene/lattice_definitions.hpp"
#endif
