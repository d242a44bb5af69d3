#pragma once
// Laws of bodies that stick, and twisting resistance. docs/adhesion.md.
#include "talus/interaction/central_attractions.hpp"
#include "talus/interaction/cohesive_spring.hpp"
#include "talus/interaction/jkr_adhesion.hpp"
#include "talus/interaction/twisting_resistance.hpp"
