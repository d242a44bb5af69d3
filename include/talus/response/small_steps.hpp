#pragma once
// The former place of talus/solver/substepping.hpp, for programs that include it.
#include "talus/solver/substepping.hpp"
