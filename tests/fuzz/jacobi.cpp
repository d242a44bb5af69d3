// Spheres, accelerated Jacobi, islands that sleep.
#include <talus/solver/accelerated_jacobi.hpp>
#include "family.hpp"

namespace fuzz {

outcome run_jacobi(const plan& p) {
  return run_family<scenario<bodies<sphere, plane>, solver<accelerated_jacobi>, transport<threads>,
                             decomposition<any_decomposition>, features<sleeping, energy_ledger>>>(
      p);
}

}  // namespace fuzz
