// expects: scenario<...> names sleeping and continuous_collision, but bodies that are followed on
#include "talus/world/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<features<sleeping>>;
#else
using scene = scenario<features<sleeping, continuous_collision>>;
#endif

const scene checked;

int main() {}
