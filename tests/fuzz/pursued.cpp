// Spheres and boxes with continuous collision.
#include "family.hpp"

namespace fuzz {

outcome run_pursued(const plan& p) {
  return run_family<
      scenario<bodies<sphere, box, plane>, transport<threads>, decomposition<any_decomposition>,
               features<continuous_collision, energy_ledger>>>(p);
}

}  // namespace fuzz
