// expects: hard_contact<...> names a part twice: keep one of the two
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<hard_contact<coulomb_friction>>;
#else
using scene = scenario<hard_contact<coulomb_friction, coulomb_friction>>;
#endif

const scene checked;

int main() {}
