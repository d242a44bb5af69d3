// expects: scenario<...> names soft_contact<...> and a feature that needs the impulses of hard
// contacts
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<hard_contact<coulomb_friction>, features<sleeping>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot>, features<sleeping>>;
#endif

const scene checked;

int main() {}
