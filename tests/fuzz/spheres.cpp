// Spheres, nonlinear Gauss-Seidel.
#include "family.hpp"

namespace fuzz {

outcome run_spheres(const plan& p) {
  return run_family<scenario<bodies<sphere, plane>, transport<threads>,
                             decomposition<any_decomposition>, features<energy_ledger>>>(p);
}

}  // namespace fuzz
