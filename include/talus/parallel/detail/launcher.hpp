#pragma once
// Moved: remove when nothing includes it any more.
#include "talus/parallel/launcher.hpp"
