// expects: soft_contact<...> takes interaction laws, such as linear_spring_dashpot and
// hertz_mindlin, coulomb_friction and rolling_resistance, and this type is not one of them
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<hard_contact<coulomb_friction, normal_cohesion>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot, normal_cohesion>>;
#endif

const scene checked;

int main() {}
