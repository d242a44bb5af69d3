// expects: scenario<...> names integrator<moreau_midpoint> and continuous_collision
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<integrator<moreau_midpoint>>;
#else
using scene = scenario<integrator<moreau_midpoint>, features<continuous_collision>>;
#endif

const scene checked;

int main() {}
