#pragma once
// Spheres and boxes over planes, hard contacts solved alike on any ranks, to the bit, on ranks that
// are divided in any way.
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/coloured_gauss_seidel.hpp>

#include "shared.hpp"

namespace scenes {
using reproduced =
    talus::scenario<talus::bodies<talus::sphere, talus::box, talus::plane>,
                    talus::solver<talus::reproducible>, talus::transport<talus::threads>,
                    talus::decomposition<talus::any_decomposition>>;
}
TALUS_SHARED_SOLIDS(scenes::reproduced);
