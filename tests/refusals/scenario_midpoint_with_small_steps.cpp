// expects: scenario<...> names integrator<moreau_midpoint> and solver<small_steps>
#include "talus/response/small_steps.hpp"
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<small_steps>>;
#else
using scene = scenario<solver<small_steps>, integrator<moreau_midpoint>>;
#endif

const scene checked;

int main() {}
