#pragma once
// Settings of every contact solver.
#include "talus/core/math.hpp"

namespace talus {

/// The effort for the contact problem: a number of iterations, or until the contact residual (see
/// measure_residual) is within a tolerance.
struct solver_settings {
  int iterations = 10;            ///< sweeps over all contacts per step; 5 to 50
  real tolerance = 0;             ///< contact residual to reach, 1e-2 to 1e-8; 0: fixed iterations
  int max_iterations = 1000;      ///< upper limit, if a tolerance is set
  int correction_iterations = 3;  ///< sweeps of the position correction; 1 to 5
  real correction = 0.2;          ///< part of an overlap that is corrected per step, in [0, 1]
};

}  // namespace talus
