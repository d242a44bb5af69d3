// Spheres and boxes in a periodic box: the invariants, and the same bits as on one rank.
#include <talus/parallel/periodic.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>

#include "family.hpp"

namespace fuzz {

outcome run_around(const plan& p) {
  using sides = decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>;
  using shapes = bodies<sphere, box, plane>;
  if (p.seed % 2 != 0)
    return run_family<scenario<shapes, transport<threads>, sides, features<energy_ledger>>>(p);
  using scene =
      scenario<shapes, solver<reproducible>, transport<threads>, sides, features<energy_ledger>>;
  return run_on_one_too<scene>(p);
}

}  // namespace fuzz
