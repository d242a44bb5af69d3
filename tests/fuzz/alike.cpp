// Spheres and boxes, the reproducible solver: the same bits as on one rank.
#include <talus/solver/coloured_gauss_seidel.hpp>
#include "family.hpp"

namespace fuzz {

outcome run_alike(const plan& p) {
  using scene = scenario<bodies<sphere, box, plane>, solver<reproducible>, transport<threads>,
                         decomposition<any_decomposition>, features<energy_ledger>>;
  return run_on_one_too<scene>(p);
}

}  // namespace fuzz
