#pragma once
// What every contact solver can be told.
#include "talus/core/math.hpp"

namespace talus {

/// How hard the contact problem is worked on.
struct solver_settings {
  int iterations = 10;            ///< sweeps over all contacts per step; 5 to 50
  int correction_iterations = 3;  ///< sweeps of the correction of overlaps; 1 to 5
  real correction = 0.2;          ///< part of an overlap that is corrected per step, in [0, 1]
};

}  // namespace talus
