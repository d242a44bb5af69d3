#pragma once
// For features of one's own: what their hooks see of a world. docs/features.md.
#include "talus/world/stage_view.hpp"
#include "talus/world/world.hpp"
