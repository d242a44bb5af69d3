#pragma once
// Sites: the places that world.fill(sites, ...) visits. A site set is enumerated part by part, so
// that a rank pays for its own part of space only.
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "talus/concepts.hpp"
#include "talus/core/error.hpp"

namespace talus {

/// A place for a body.
struct site {
  /// position for a body
  vec3 position{0, 0, 0};
  /// orientation for a body
  quat orientation{1, 0, 0, 0};
  std::uint64_t index = 0;  ///< number of the site in its set, on every rank; below 2^48
};

/// Calls f(site) for the sites between two corners (which may be infinite) that are in the part of
/// space given by contains(position).
template <class Sites, class Contains, class F>
void for_each_site(const Sites& sites, const vec3& lower, const vec3& upper, Contains&& contains,
                   F&& f) {
  static_assert(concepts::site_set<Sites>,
                "fill takes sites, and this type is not one: a bare lattice has no end, so write "
                "lattice & region, as in simple_cubic{.spacing = 2} & box_region{...}");
  if constexpr (concepts::site_set<Sites>)
    sites.for_each_in(lower, upper, [&](const site& s) {
      if (contains(s.position)) f(s);
    });
}

namespace detail {

inline constexpr real unlimited = std::numeric_limits<real>::infinity();

[[nodiscard]] inline bool between(const vec3& lower, const vec3& p, const vec3& upper) {
  for (int k = 0; k < 3; ++k)
    if (!(p[k] >= lower[k] && p[k] <= upper[k])) return false;
  return true;
}

[[noreturn]] inline void fail_too_few_sites(std::uint64_t wanted, std::uint64_t there) {
  fail<std::invalid_argument>(
      "first({}) asks for more sites than there are, {}: enlarge the region or ask for fewer",
      wanted, there);
}

/// A type with contains(point) that is not a site set itself.
template <class Region>
concept site_filter = !concepts::site_set<Region> && requires(const Region r, const vec3 p) {
  { r.contains(p) } -> std::convertible_to<bool>;
};

}  // namespace detail

/// The first sites of a set in its own order; made by first(n). Every rank enumerates all of them.
template <class Sites>
class first_sites {
 public:
  using site_type = site;

  first_sites(Sites sites, std::uint64_t n) : sites_(std::move(sites)), n_(n) {}

  template <class F>
  void for_each_in(const vec3& lower, const vec3& upper, F&& f) const {
    const vec3 all = detail::thrice<real>(detail::unlimited);
    std::uint64_t seen = 0;
    sites_.for_each_in(-all, all, [&](const site& s) {
      if (seen++ < n_ && detail::between(lower, s.position, upper)) f(s);
    });
    if (seen < n_) detail::fail_too_few_sites(n_, seen);
  }

 private:
  Sites sites_;
  std::uint64_t n_;
};

/// The sites of a set that lie in a region; made by `sites & region`. They keep their indices.
template <class Sites, class Region>
class sites_in {
 public:
  using site_type = site;

  sites_in(Sites sites, Region region) : sites_(std::move(sites)), region_(std::move(region)) {}

  template <class F>
  void for_each_in(const vec3& lower, const vec3& upper, F&& f) const {
    sites_.for_each_in(lower, upper, [&](const site& s) {
      if (region_.contains(s.position)) f(s);
    });
  }
  [[nodiscard]] auto first(std::uint64_t n) const { return first_sites<sites_in>(*this, n); }

 private:
  Sites sites_;
  Region region_;
};

template <concepts::site_set Sites, detail::site_filter Region>
[[nodiscard]] auto operator&(Sites sites, Region region) {
  if constexpr (requires { sites.within(region); })
    return sites.within(std::move(region));
  else
    return sites_in<Sites, Region>(std::move(sites), std::move(region));
}

/// Given places, in the order given.
class points {
 public:
  using site_type = site;

  explicit points(std::vector<vec3> positions) : positions_(std::move(positions)) {}

  template <class F>
  void for_each_in(const vec3& lower, const vec3& upper, F&& f) const {
    for (std::size_t i = 0; i < positions_.size(); ++i)
      if (detail::between(lower, positions_[i], upper)) f(site{positions_[i], {1, 0, 0, 0}, i});
  }
  [[nodiscard]] auto first(std::uint64_t n) const { return first_sites<points>(*this, n); }

 private:
  std::vector<vec3> positions_;
};

}  // namespace talus
