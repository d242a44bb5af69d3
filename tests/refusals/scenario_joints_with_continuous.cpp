// expects: names joints and continuous_collision, which follows bodies without their joints
#include "pin.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<pin>, features<orientation>>;
#else
using scene = scenario<joints<pin>, features<continuous_collision>>;
#endif

const scene checked;

int main() {}
