// expects: scenario<...> names integrator<moreau_midpoint> and soft_contact<...>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<integrator<moreau_midpoint>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot>, integrator<moreau_midpoint>>;
#endif

const scene checked;

int main() {}
