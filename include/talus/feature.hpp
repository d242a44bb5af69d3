#pragma once
// For user-defined features: the view of the world that their hooks take. docs/features.md.
#include "talus/world/stage_view.hpp"
#include "talus/world/world.hpp"
