// expects: scenario<...> names integrator<moreau_midpoint> and solver<small_steps>
#include "talus/scenario/scenario.hpp"
#include "talus/solver/small_steps.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<small_steps>>;
#else
using scene = scenario<solver<small_steps>, integrator<moreau_midpoint>>;
#endif

const scene checked;

int main() {}
