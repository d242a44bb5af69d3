// The domains of a plan and of a mechanism.
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/bisection.hpp>
#include <talus/parallel/cells.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/hexagonal.hpp>
#include <talus/parallel/ring.hpp>
#include <talus/parallel/slabs.hpp>

#include "mechanism.hpp"

namespace fuzz {

using namespace talus;

any_decomposition decomposition_of(const plan& p) {
  random_stream r(p.seed, 3);
  const real L = p.side;
  switch (p.how) {
    case domains::grid:
      return grid<dynamic, dynamic, dynamic>{.lower = {-L, -L, -L}, .upper = {L, L, L}};
    case domains::hexagonal:
      return hexagonal<dynamic>{.spacing = r.uniform(1.5, 4), .centre = r.in_ball(0.5)};
    case domains::ring:
      return ring<dynamic>{.hub = 0.5};
    case domains::slabs:
      return slabs<dynamic>{.axis = r.unit_vector(), .lower = -L, .upper = L};
    case domains::cells: {
      // Half-spaces that are cut from the rest, one after the other.
      std::vector<any_geometry> regions;
      for (int k = 0; k + 1 < p.ranks; ++k)
        regions.emplace_back(half_space(r.unit_vector(), r.uniform(0.5, 3)));
      regions.emplace_back(merge(half_space(1, 0, 0, 0), half_space(-1, 0, 0, 0)));  // the rest
      return cells(std::move(regions));
    }
  }
  return {};
}

/// Another one for each variant.
any_decomposition decomposition_of(const mechanism& m, int ranks, std::uint64_t variant) {
  random_stream r(m.seed, 5 + variant);
  const real L = m.side;
  const vec3 by = 0.1 * r.in_ball();
  switch (variant == 0 ? m.how : static_cast<mechanism::domains>(r.integer(4))) {
    case mechanism::domains::grid:
      return grid<dynamic, dynamic, dynamic>{.lower = {by[0] - L, by[1] - L, by[2] - L},
                                             .upper = {by[0] + L, by[1] + L, by[2] + L}};
    case mechanism::domains::slabs:
      return slabs<dynamic>{.axis = r.unit_vector(), .lower = -L, .upper = L};
    case mechanism::domains::bisection:
      return bisection<dynamic>{.lower = {.x = by[0] - L, .y = by[1] - L},
                                .upper = {.x = by[0] + L, .y = by[1] + L}};
    case mechanism::domains::hexagonal:
      if (ranks == 7) return hexagonal<dynamic>{.spacing = L, .centre = by};
      [[fallthrough]];
    case mechanism::domains::cells: {
      std::vector<any_geometry> regions;
      for (int k = 0; k + 1 < ranks; ++k)
        regions.emplace_back(half_space(r.unit_vector(), r.uniform(0, 0.5 * L)));
      regions.emplace_back(merge(half_space(1, 0, 0, 0), half_space(-1, 0, 0, 0)));  // the rest
      return cells(std::move(regions));
    }
  }
  return {};
}

}  // namespace fuzz
