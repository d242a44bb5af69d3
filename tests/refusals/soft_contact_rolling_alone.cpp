// expects: soft_contact<...> names rolling_resistance without coulomb_friction
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot, coulomb_friction, rolling_resistance>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot, rolling_resistance>>;
#endif

const scene checked;

int main() {}
