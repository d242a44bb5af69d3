// Random mechanisms: the same on any ranks, no energy from nothing, no joint that opens.
#include "mechanism_run.hpp"

namespace fuzz {

outcome run_mechanisms(const plan& p) {
  using scene = scenario<bodies<sphere, box, plane>, solver<nonlinear_gauss_seidel, reproducible>,
                         joints<ball_joint, fixed_joint, weld, hinge, slider, cylindrical_joint,
                                universal_joint, rod, rope, strut, point_on_plane, gear>,
                         transport<threads>, decomposition<any_decomposition>,
                         features<sleeping, driven, balancing, energy_ledger, checkpoints>>;
  return check_mechanism(p, false, run_mechanism<scene>);
}

}  // namespace fuzz
