#pragma once
// The former place of talus/solver/accelerated_jacobi.hpp, for programs that include it.
#include "talus/solver/accelerated_jacobi.hpp"
