// expects: scenario<...> names integrator<velocity_verlet> and hard contacts, whose impulses are no
// forces
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot>, integrator<velocity_verlet>>;
#else
using scene = scenario<integrator<velocity_verlet>>;
#endif

const scene checked;

int main() {}
