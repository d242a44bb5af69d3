// expects: scenario<...> takes the parts of a contact law inside soft_contact<...>: write
// soft_contact<linear_spring_dashpot>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<linear_spring_dashpot>>;
#else
using scene = scenario<linear_spring_dashpot>;
#endif

const scene checked;

int main() {}
