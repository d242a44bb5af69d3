// expects: scenario<...> takes a feature inside features<...>
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<features<damping>>;
#else
using scene = scenario<damping>;
#endif

const scene checked;

int main() {}
