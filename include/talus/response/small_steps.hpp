#pragma once
// The former place of talus/solver/small_steps.hpp, for programs that include it.
#include "talus/solver/small_steps.hpp"
