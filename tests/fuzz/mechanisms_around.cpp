// Random mechanisms in a periodic box.
#include <talus/parallel/periodic.hpp>

#include "mechanism_run.hpp"

namespace fuzz {

outcome run_mechanisms_around(const plan& p) {
  using scene = scenario<bodies<sphere, box, plane>, solver<nonlinear_gauss_seidel, reproducible>,
                         joints<ball_joint, fixed_joint, weld, hinge, slider, cylindrical_joint,
                                universal_joint, rod, rope, strut, point_on_plane, gear>,
                         transport<threads>,
                         decomposition<periodic<grid<dynamic, dynamic>, along::x, along::y>>,
                         features<sleeping, driven, energy_ledger, checkpoints>>;
  return check_mechanism(p, true, run_mechanism<scene>);
}

}  // namespace fuzz
