// expects: soft_contact<...> names no spring: add linear_spring_dashpot or hertz_mindlin, or an
// expects: interaction law of your own
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<hertz_mindlin, coulomb_friction>>;
#else
using scene = scenario<soft_contact<coulomb_friction>>;
#endif

const scene checked;

int main() {}
