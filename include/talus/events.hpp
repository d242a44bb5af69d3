#pragma once
// The events of a step: features<events>, and what reads them. docs/features.md.
#include "talus/features/events.hpp"
#include "talus/observe/event_table.hpp"
#include "talus/world/stage_view.hpp"
#include "talus/world/world.hpp"
