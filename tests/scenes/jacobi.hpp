#pragma once
// Spheres and boxes over planes, hard contacts solved by Jacobi's method, on ranks that are divided
// in any way.
#include <talus/parallel/any_decomposition.hpp>
#include <talus/parallel/threads.hpp>
#include <talus/solver/accelerated_jacobi.hpp>

#include "shared.hpp"

namespace scenes {
using jacobi =
    talus::scenario<talus::bodies<talus::sphere, talus::box, talus::plane>,
                    talus::solver<talus::accelerated_jacobi>, talus::transport<talus::threads>,
                    talus::decomposition<talus::any_decomposition>>;
}
TALUS_SHARED_SOLIDS(scenes::jacobi);
