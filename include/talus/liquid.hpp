#pragma once
// Liquid that belongs to bodies: features<surface_liquid>, the bridges that take it, and their
// observers total_liquid and for_each_bridge. docs/liquid_bridges.md.
#include "talus/features/surface_liquid.hpp"
#include "talus/interaction/liquid_bridge.hpp"
#include "talus/observe/liquid.hpp"
#include "talus/world/stage_view.hpp"
#include "talus/world/world.hpp"
