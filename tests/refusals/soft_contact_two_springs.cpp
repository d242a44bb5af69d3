// expects: soft_contact<...> names linear_spring_dashpot and hertz_mindlin, which contradict each
// other
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<soft_contact<hertz_mindlin>>;
#else
using scene = scenario<soft_contact<hertz_mindlin, linear_spring_dashpot>>;
#endif

const scene checked;

int main() {}
