// Spheres with soft contacts.
#include "family.hpp"

namespace fuzz {

outcome run_springs(const plan& p) {
  return run_family<scenario<bodies<sphere, plane>, soft_contact<linear_spring_dashpot>,
                             transport<threads>, decomposition<any_decomposition>>>(p);
}

}  // namespace fuzz
