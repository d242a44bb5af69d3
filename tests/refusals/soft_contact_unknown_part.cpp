// expects: soft_contact<...> takes interaction laws, such as linear_spring_dashpot and hertz_mindlin,
// expects: coulomb_friction and rolling_resistance, and this type is not one of them
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<hertz_mindlin>>;
#else
using scene = scenario<soft_contact<hertz_mindlin, newton_restitution>>;
#endif

const scene checked;

int main() {}
