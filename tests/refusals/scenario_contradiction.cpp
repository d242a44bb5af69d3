// expects: hard_contact<...> names split_correction and no_correction, which contradict each other:
// keep one of them
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<hard_contact<coulomb_friction, no_correction>>;
#else
using scene = scenario<hard_contact<split_correction, coulomb_friction, no_correction>>;
#endif

const scene checked;

int main() {}
