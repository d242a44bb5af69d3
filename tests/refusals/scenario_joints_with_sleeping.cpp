// expects: names joints and continuous_collision or sleeping, which do not see joints yet
#include "pin.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<pin>, features<orientation>>;
#else
using scene = scenario<joints<pin>, features<sleeping>>;
#endif

const scene checked;

int main() {}
