// Spheres and boxes, the reproducible solver: the same bits as on one rank.
#include <talus/response/coloured_gauss_seidel.hpp>
#include "family.hpp"

namespace fuzz {

outcome run_alike(const plan& p) {
  using scene = scenario<bodies<sphere, box, plane>, solver<reproducible>, transport<threads>,
                         decomposition<any_decomposition>>;
  const outcome many = run_family<scene>(p);
  plan single = p;
  single.ranks = 1;
  const outcome one = run_family<scene>(single);
  if (many.refused.empty() && one.refused.empty() && many.digest != one.digest)
    fail("one rank ends with " + one.digest + ", these with " + many.digest);
  return many;
}

}  // namespace fuzz
