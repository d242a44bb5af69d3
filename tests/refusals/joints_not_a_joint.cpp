// expects: joints<...> takes kinds of joints, and this type is not one: remove it
#include "talus/scenario/scenario.hpp"
using namespace talus;

#ifdef TALUS_CONTROL
using scene = scenario<joints<>>;
#else
using scene = scenario<joints<sphere>>;
#endif

const scene checked;

int main() {}
