#define RUBBLE_STEPS
#include "rubble.hpp"
