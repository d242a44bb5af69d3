// expects: scenario<...> names soft_contact<...> and a feature that needs the impulses of hard
// contacts
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot>, features<energy_ledger>>;
#else
using scene = scenario<soft_contact<linear_spring_dashpot>, features<residual_monitor>>;
#endif

const scene checked;

int main() {}
