#pragma once
// Spheres over planes, hard contacts, on one rank.
#include <talus/parallel/serial.hpp>

#include "shared.hpp"

namespace scenes {
using spheres_alone =
    talus::scenario<talus::bodies<talus::sphere, talus::plane>, talus::transport<talus::serial>>;
}
TALUS_SHARED_SPHERES(scenes::spheres_alone);
