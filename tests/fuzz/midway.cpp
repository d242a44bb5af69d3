// Spheres and boxes that are followed to their impacts, with contacts in the middle of the step.
#include "family.hpp"

namespace fuzz {

outcome run_midway(const plan& p) {
  return run_family<
      scenario<bodies<sphere, box, plane>, transport<threads>, decomposition<any_decomposition>,
               integrator<moreau_midpoint>, features<continuous_collision, energy_ledger>>>(p);
}

}  // namespace fuzz
