#pragma once
// The former place of talus/solver/coloured_gauss_seidel.hpp, for programs that include it.
#include "talus/solver/coloured_gauss_seidel.hpp"
