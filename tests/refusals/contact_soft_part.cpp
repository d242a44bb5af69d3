// expects: hard_contact<...> takes coulomb_friction, newton_restitution, normal_cohesion,
// split_correction and no_correction, and this type is not one of them
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot, coulomb_friction>>;
#else
using scene = scenario<hard_contact<linear_spring_dashpot, coulomb_friction>>;
#endif

const scene checked;

int main() {}
