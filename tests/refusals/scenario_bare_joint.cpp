// expects: scenario<...> takes a joint inside joints<...>: write joints<ball_joint> for a bare ball_joint
#include "pin.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<pin>>;
#else
using scene = scenario<pin>;
#endif

const scene checked;

int main() {}
