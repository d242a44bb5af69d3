// expects: joints<...> names a kind of joint twice: keep one of the two
#include "pin.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<pin>>;
#else
using scene = scenario<joints<pin, pin>>;
#endif

const scene checked;

int main() {}
