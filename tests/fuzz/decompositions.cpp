// The domains of a plan.
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/cells.hpp>
#include <talus/parallel/grid.hpp>
#include <talus/parallel/hexagonal.hpp>
#include <talus/parallel/ring.hpp>
#include <talus/parallel/slabs.hpp>

#include "plan.hpp"

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

}  // namespace fuzz
