// expects: scenario<...> names integrator<moreau_midpoint> and solver<substepping>
#include "talus/scenario/scenario.hpp"
#include "talus/solver/substepping.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<solver<substepping>>;
#else
using scene = scenario<solver<substepping>, integrator<moreau_midpoint>>;
#endif

const scene checked;

int main() {}
