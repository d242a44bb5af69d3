#pragma once
// Spheres over planes, hard contacts, on ranks that are divided in any way.
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/threads.hpp>

#include "shared.hpp"

namespace scenes {
using spheres =
    talus::scenario<talus::bodies<talus::sphere, talus::plane>, talus::transport<talus::threads>,
                    talus::decomposition<talus::any_decomposition>>;
}
TALUS_SHARED_SPHERES(scenes::spheres);
