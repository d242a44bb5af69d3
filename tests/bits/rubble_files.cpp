#define RUBBLE_FILES
#include "rubble.hpp"
