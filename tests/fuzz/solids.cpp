// Spheres, boxes, capsules and unions.
#include "family.hpp"

namespace fuzz {

outcome run_solids(const plan& p) {
  return run_family<
      scenario<bodies<sphere, box, capsule, union_of<sphere, box>, plane>, transport<threads>,
               decomposition<any_decomposition>, features<energy_ledger>>>(p);
}

}  // namespace fuzz
