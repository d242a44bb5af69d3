// The compiled part: ranks as threads, domains, and parts of space.
#include "talus/geometry/detail/any_geometry_definitions.hpp"
#include "talus/parallel/detail/thread_team_definitions.hpp"
#include "talus/parallel/grid_definitions.hpp"
#include "talus/parallel/threads_definitions.hpp"
