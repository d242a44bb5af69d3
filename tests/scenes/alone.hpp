#pragma once
// Spheres and boxes over planes, hard contacts, on one rank.
#include <talus/parallel/serial.hpp>

#include "shared.hpp"

namespace scenes {
using alone = talus::scenario<talus::bodies<talus::sphere, talus::box, talus::plane>,
                              talus::transport<talus::serial>>;
}
TALUS_SHARED_SOLIDS(scenes::alone);
