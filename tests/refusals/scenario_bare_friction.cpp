// expects: scenario<...> takes the parts of a contact law inside hard_contact<...>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<hard_contact<coulomb_friction>>;
#else
using scene = scenario<coulomb_friction>;
#endif

const scene checked;

int main() {}
